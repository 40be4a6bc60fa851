"""A speed that one letter alone tells is used only if it goes with the position."""

import numpy as np
import pytest

TIME = np.arange(3000) * 2e-3
ANGLE = np.sin(3.0 * TIME)


@pytest.mark.parametrize(
    ("name", "goes", "used"), [("v", False, False), ("v", True, True), ("motor speed", False, True)]
)
def test_a_letter_that_the_motion_contradicts_is_not_used(name, goes, used, drafted):
    speed = 3.0 * np.cos(3.0 * TIME) + (0.0 if goes else 9.0 * np.cos(7.0 * TIME))
    draft = drafted({"t": TIME, "theta": ANGLE, name: speed, "current [A]": np.cos(3.0 * TIME)})
    assert ("  speed:" in draft.map) is used
    assert (f"{name}: not used: " in draft.said and "a letter alone does not tell a speed" in draft.said) is not used


def test_a_position_of_one_letter_goes_where_the_speed_is_named(drafted):
    speed = 3.0 * np.cos(3.0 * TIME) + 9.0 * np.cos(7.0 * TIME)
    draft = drafted({"t": TIME, "x": ANGLE, "motor speed": speed, "current [A]": np.cos(3.0 * TIME)})
    assert "  motor_position:" not in draft.map and "a letter alone does not tell a position" in draft.said

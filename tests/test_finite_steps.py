"""Finite differences stay within a number's bounds, to whichever side there is room."""

import pytest

from ema_twin_sim.identification.hypothesis import Free
from ema_twin_sim.identification.jacobian import inner_step


@pytest.mark.parametrize(
    ("value", "lower", "upper", "step"),
    [
        (0.5, 0.0, 1.0, 0.1),
        (0.0, 0.0, 1.0, 0.1),
        (1.0, 0.0, 1.0, -0.1),
        (0.02, 0.0, 0.08, 0.06),  # neither side has room for a whole step
        (0.07, 0.0, 0.08, -0.07),
    ],
)
def test_a_step_stays_inside(value, lower, upper, step):
    found = inner_step(Free("effects.a.b", lower, upper, 0.1), value)
    assert found == pytest.approx(step)
    assert lower <= value + found <= upper


def test_what_is_held_has_a_slope_all_the_same():
    assert abs(inner_step(Free("contact.stiffness", 3.0, 3.0, 0.1), 3.0)) == 0.1

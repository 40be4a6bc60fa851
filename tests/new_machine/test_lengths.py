"""A rotary motor that moves a nut, measured in a unit of length: the option that init tells to use it."""

import numpy as np
import pytest

TIME = np.arange(3000) * 2e-3
LEAD = 0.005  # m
ANGLE = 20.0 * (1.0 - np.cos(3.0 * TIME))
CURRENT = 0.5 * np.sign(np.sin(3.0 * TIME)) + 0.3 * np.cos(3.0 * TIME)


@pytest.mark.parametrize(("unit", "size"), [("um", 1e-6), ("mm", 1e-3)])
def test_a_nut_behind_a_screw_is_read_as_told(unit, size, drafted, read):
    name = f"output position [{unit}]"
    nut = np.round(ANGLE * LEAD / (2.0 * np.pi) / size, 3)
    columns = {"time [s]": TIME, name: nut, "motor position [mrad]": 1e3 * ANGLE, "motor current [A]": CURRENT}
    said = drafted(columns).said
    assert "if the motor moves it by a screw, a belt or a rack, give the way per turn, as in --travel-per-turn" in said
    assert f"{name} → output_position" in drafted(columns, travel_per_turn=LEAD).said
    recording = read()
    for signal in ("motor_position", "output_position"):
        way = ANGLE * LEAD / (2.0 * np.pi)
        assert np.allclose(recording.signals[signal], way, atol=1e-3 * np.ptp(way))


def test_a_force_of_a_rotary_machine_is_no_length(drafted):
    columns = {"time [s]": TIME, "motor position [rad]": ANGLE, "motor current [A]": CURRENT, "force [N]": CURRENT}
    assert "screw" not in drafted(columns).said

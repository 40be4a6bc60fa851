"""Columns that a symbol alone makes a position: flows, a power analyser's angles, and what is asked of the others."""

import numpy as np
import pytest

from tests.taken_columns import taken

TURNS = np.linspace(0.0, 1.0, 60)
DRAG = {"torque [N m]": 2.0 + 3.0 * TURNS, "speed [rpm]": 6000.0 * TURNS}


@pytest.mark.parametrize(
    "unit", ["l/min", "L/min", "l/s", "ml/min", "m3/h", "m³/h", "m^3/h", "dm³/min", "kg/s", "lpm", "gpm", "gal/min"]
)
def test_a_flow_is_no_signal(unit):
    """A coolant's Q [l/min] was read as the motor's position, and a Volumenstrom as its current."""
    flows = {f"LEW_Q_P1 [{unit}]": 7.9 + TURNS, f"Volumenstrom [{unit}]": 8.0 + TURNS}
    assert set(taken({**DRAG, **flows})) == {"motor_torque", "speed"}


def analyser(angle):
    """What a power analyser measures of three phases, with the names that ``angle`` makes of their numbers."""
    return {
        name: values
        for k in (1, 2, 3)
        for name, values in {
            f"PA1_S_{k} [VA]": 800.0 + 50.0 * k * TURNS,
            f"PA1_Q_{k} [var]": 790.0 + TURNS,
            angle.format(k): 30.0 * k + 50.0 * TURNS,
        }.items()
    }


@pytest.mark.parametrize("angle", ["PA1_PHI_{} [°]", "PA1_PHI_{}", "cos phi {}", "Phasenwinkel {} [°]"])
def test_an_angle_between_voltage_and_current_is_no_position(angle, drafted):
    columns = {**DRAG, **analyser(angle)}
    assert set(taken(columns)) == {"motor_torque", "speed"}
    draft = drafted(columns, operating_points=True)
    assert (
        f"{angle.format(3)}: not used, since power analysers give the angle between voltage and current" in draft.said
    )


def test_an_angle_beside_a_mechanical_power_is_a_position():
    columns = {"phi [deg]": 40.0 * TURNS, "P [W]": TURNS, "torque [N m]": 2.0 + TURNS}
    assert taken(columns)["motor_position"] == "phi [deg]"


def test_an_unnamed_position_beside_a_speed_in_a_table_is_asked_about(drafted):
    for name, asked in (("beta [deg]", True), ("motor beta [deg]", False), ("angle [deg]", False)):
        draft = drafted({**DRAG, name: 30.0 * TURNS**2}, operating_points=True)
        assert (f"{name}: a position, though no word of its name tells one" in draft.said) == asked
        assert ("CHECK" in draft.line("motor_position")) == asked


@pytest.mark.parametrize(("names", "asked"), [(("beta", "gamma"), True), (("q motor", "q load"), False)])
def test_two_unnamed_positions_make_no_gear_ratio_silently(names, asked, drafted):
    time = np.arange(800) * 2e-3
    angle = 90.0 * np.sin(3.0 * time)
    columns = dict(zip((f"{name} [deg]" for name in names), (angle, angle / 7.0), strict=True))
    draft = drafted({"time [s]": time, **columns, "current [A]": np.cos(3.0 * time)})
    assert "value: 7," in draft.line("gear_ratio")
    assert ("CHECK" in draft.line("gear_ratio")) == asked
    assert ("no word of their names tells a motor or an output" in draft.said) == asked


@pytest.mark.parametrize(
    ("name", "signal"),
    [
        ("qD [deg/s]", "speed"),
        ("theta_d [rad/s]", "speed"),
        ("w_d [rad/s]", "speed_setpoint"),
        ("q_d [deg]", "output_command"),
    ],
)
def test_a_d_beside_a_positions_symbol_is_a_dot_where_the_unit_is_a_speeds(name, signal):
    """Robots' logs write q, qD and qDD; a desired speed has a speed's symbol, as a desired position a position's."""
    way = np.degrees(TURNS**2)
    found = taken({"time [s]": TURNS, "q [deg]": way, name: np.gradient(way, TURNS), "tau [N m]": 1.0 + TURNS})
    assert found.get(signal) == name

"""A torque beside a current in a table of operating points may be a dynamometer's: `init` asks."""

import numpy as np
import pytest

SPEED = np.linspace(0.0, 5600.0, 60)
TORQUE = 3.2 * (1.0 - SPEED / 5700.0)
CURRENT = TORQUE / 0.018 + 1.8 + 2e-4 * SPEED  # for no load, friction
TIME = np.arange(600) * 2e-3
DRIVEN = 0.1 * np.sign(np.sin(6.0 * TIME)) + 0.05 * np.cos(6.0 * TIME)
MOVED = {"speed [rad/s]": 40.0 * np.sin(6.0 * TIME), "Torque (Nm)": DRIVEN, "Current (A)": DRIVEN / 0.018}
ASKED = "each row is an operating point, where a torque measured at the shaft goes with Current (A) too"


def table(torque):
    return {"Speed (RPM)": SPEED, torque: np.round(TORQUE, 4), "Current (A)": np.round(CURRENT, 3)}


@pytest.mark.parametrize("name", ["Torque (Nm)", "M (Nm)", "Measured torque [N m]"])
def test_it_is_asked_whose_torque_it_is(drafted, name):
    draft = drafted(table(name))
    assert f"{name} → motor_torque" in draft.said
    asked = f"{name}: the motor's torque, though {ASKED} (if a dynamometer or a load sensor measured it, say so"
    assert asked in draft.said and "as in 'load torque [N m]'" in draft.said
    assert f"# CHECK: {ASKED}: is it the motor's, or a dynamometer's?" in draft.map


@pytest.mark.parametrize(
    ("columns", "signal"),
    [
        (table("load torque (Nm)"), "load_torque"),  # which follows that
        *((table(f"{name} torque (Nm)"), "motor_torque") for name in ("motor", "estimated", "calculated")),
        ({**table("Torque (Nm)"), "Torque (Nm)": 0.018 * CURRENT, "Current (A)": CURRENT}, "motor_torque"),  # computed
        ({"time [s]": TIME, **MOVED}, "motor_torque"),  # samples of a motion
    ],
)
def test_nothing_is_asked(drafted, columns, signal):
    draft = drafted(columns)
    assert f"→ {signal}" in draft.said and "dynamometer" not in draft.said + draft.map


def test_a_torque_alone_tells_what_is_lacking(drafted):
    """Its noise depends on nothing that was recorded."""
    assert "No motor position or speed was found" in drafted({"TorqueValue": np.sin(7.0 * SPEED)}).said

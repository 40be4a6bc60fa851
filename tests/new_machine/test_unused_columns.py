"""`init` reads imperial units, and says why columns that may be meant are not used."""

import numpy as np
import pytest

TIME = np.arange(800) * 2e-3
SPEED = 3.0 * np.cos(3.0 * TIME)
FORCE = 80.0 * np.sign(SPEED) - 2.0 * np.sin(3.0 * TIME)


def test_a_machine_in_inches_and_pounds_is_linear(drafted):
    columns = {"displacement (in)": np.sin(3.0 * TIME), "velocity (in/s)": SPEED, "actuator force (lb)": FORCE}
    draft = drafted({"time (s)": TIME, **columns})
    assert "motion: linear" in draft.map and "displacement (in) → motor_position in in" in draft.said
    for line in ("unit: in}", "unit: in/s}", "unit: lbf}"):
        assert line in draft.map
    assert "CHECK" not in "\n".join(draft.map.splitlines()[1:])


def test_reasons_are_given(drafted):
    columns = {"position (mm)": np.sin(3.0 * TIME), "velocity (mm/s)": SPEED, "force (N)": FORCE}
    more = {"efficiency (%)": SPEED**2, "strain (ustrain)": FORCE, "power (W)": FORCE, "clamp force (kip)": SPEED}
    said = drafted({"time (s)": TIME, **columns, **more}).said
    assert "no signal is given in these units: efficiency (%), strain (ustrain) (if one is a signal" in said
    assert "other columns are read in their place: clamp force (kip) (if one is meant" in said
    assert "power (W)" not in said


def test_many_are_counted(drafted):
    columns = {"position (mm)": np.sin(3.0 * TIME), "force (N)": FORCE}
    columns |= {f"share_{k} (%)": FORCE for k in range(10)}
    assert "share_7 (%) and 2 more (if one" in drafted({"time (s)": TIME, **columns}).said


def test_what_may_be_the_motion_is_asked_about(drafted):
    columns = {"t": TIME, "r": np.sign(SPEED), "y": np.sin(3.0 * TIME), "u": FORCE, "status": FORCE, "z": 0.0 * TIME}
    assert "r, y: not read, since their names do not tell what they are" in drafted(columns).said
    del columns["r"]
    said = drafted(columns).said
    assert "y: not read, since its name does not tell what it is, and no position or speed was found: is it one" in said
    assert "'motor position [deg]' or 'motor speed [rpm]'" in said
    assert "not read" not in drafted({**columns, "angle": SPEED}).said


@pytest.mark.parametrize("name", ["action", "motorAction_0", "cmd", "target_0"])
def test_a_command_of_no_known_quantity_is_named_on_the_screen(name, drafted):
    """A learned controller's action is a position for one machine and a torque for another."""
    columns = {"time": TIME, "angle": np.sin(3.0 * TIME), name: np.sign(np.sin(40.0 * TIME)), "torque": FORCE}
    draft = drafted(columns)
    assert f"{name}: not read, since its name does not tell what is commanded or measured (if it" in draft.said
    assert "'position command [rad]', and run init again" in draft.said and "output_command" not in draft.map


def test_what_goes_as_the_position_does_is_named_and_nothing_else(drafted):
    angle = np.sin(3.0 * TIME)
    columns = {"time": TIME, "angle": angle, "foo": 7.3 * angle + 0.1 * np.sin(40.0 * TIME), "torque": FORCE}
    assert "foo: not read, since its name does not tell" in drafted(columns).said
    assert "not read" not in drafted({**columns, "foo": np.sin(40.0 * TIME)}).said


def test_an_action_in_the_positions_unit_commands_it(drafted):
    angle = np.sin(3.0 * TIME)
    columns = {"time": TIME, "angle [rad]": angle, "action [rad]": np.sin(3.0 * TIME + 0.05), "torque": FORCE}
    assert "action [rad] → output_command" in drafted(columns).said


def test_what_may_be_the_missing_current_is_asked_about(drafted):
    columns = {"t": TIME, "rpm": SPEED, "rpm_sp": 1.1 * SPEED, "out": FORCE, "sp": SPEED**2, "z": 0.0 * TIME}
    columns["index"] = np.arange(len(TIME))  # the number of a row is nothing to ask about
    said = drafted(columns).said
    assert (
        "out: not read, since its name does not tell what it is, and no current or torque was found: is it one" in said
    )
    assert "'motor current [A]' or 'torque command [N m]'" in said
    for more in ({"torque": FORCE}, {"duty": FORCE}):  # which there is, or which may stand for it
        assert "out: not read" not in drafted({**columns, **more}).said

"""`init` with a current and a torque: one thing in two units, a load behind the machine, or a current of a supply."""

import numpy as np
import pytest

from ema_bench_replay.recording import POINTS, Recording
from ema_twin_sim.new_machine.torque_beside_current import counts_against, measured_behind, not_proportional, proportion
from tests.recorded import sampled

TIME = np.arange(3000) * 5e-3
SPEED = 200.0 + 150.0 * np.sin(0.8 * TIME)
TORQUE = 2e-6 * SPEED**2 + 1e-4 * np.gradient(SPEED, TIME)
RANDOM = np.random.default_rng(5)


def noisy(values, share):
    return values + share * np.std(values) * RANDOM.standard_normal(len(values))


CURRENTS = {
    "motor": noisy(TORQUE / 0.03, 0.02),
    "motor, noisy": noisy(TORQUE / 0.03, 0.3),
    "motor, turned": noisy(-TORQUE / 0.03, 0.02),
    "supply": noisy(TORQUE * SPEED / 24.0 + 0.1, 0.02),
    "magnetising": noisy(np.sqrt(4.0 + (TORQUE / 0.03) ** 2), 0.02),
}
OWN = {"motor", "motor, noisy", "motor, turned"}


@pytest.mark.parametrize("kind", CURRENTS)
@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("of_points", [False, True])
def test_a_motors_current_is_its_torque_times_a_factor(kind, size, of_points):
    signals = {"current": CURRENTS[kind], "motor_torque": size * noisy(TORQUE, 0.02)}
    metadata = {POINTS: "yes"} if of_points else {}
    recording = sampled("r", TIME, signals, metadata=metadata)
    own = kind in OWN and not (of_points and kind == "motor, noisy")  # rows in any order tell no noise
    assert (not_proportional([recording]) is None) == own


def test_few_rows_or_none_tell_nothing():
    stamps = np.arange(10) * 1_000_000
    few = Recording("r", stamps, {"current": np.arange(10.0), "motor_torque": np.arange(10.0) ** 2})
    assert not_proportional([few]) is None and not_proportional([]) is None
    none = Recording("r", np.arange(50) * 1_000_000, {"current": np.zeros(50), "motor_torque": np.zeros(50)})
    assert not_proportional([none]) is None


def beside(kind, name="Torque (N·m)", current="Current (A)"):
    return {"Time (s)": TIME, name: TORQUE, current: CURRENTS[kind], "Speed (rad/s)": SPEED}


@pytest.mark.parametrize("kind", ["motor", "supply", "magnetising"])
def test_the_torque_is_used_and_said_if_the_current_is_not_the_motors(drafted, kind):
    draft = drafted(beside(kind))
    assert ("  current: " in draft.map) == (kind == "motor")
    assert ("Current (A): not used: Torque (N·m) is not proportional to it" in draft.said) == (kind != "motor")
    assert ("torque constant 30.0 mN m/A (torque over current" in draft.said) == (kind == "motor")
    to_check = "# CHECK: used in place of the current, to which it is not proportional"
    assert (to_check in draft.line("motor_torque")) == (kind != "motor")


@pytest.mark.parametrize("name", ["load torque [N m]", "torque sensor [N m]", "brake torque [N m]", "torque"])
def test_a_torque_named_a_load_or_without_a_unit_leaves_the_current(drafted, name):
    assert "  current: " in drafted(beside("supply", name)).map


@pytest.mark.parametrize("name", ["motor current [A]", "iq [A]", "I_q [A]", "Motorstrom [A]"])
def test_a_current_named_the_motors_is_used(drafted, name):
    assert "  current: " in drafted(beside("magnetising", current=name)).map


def test_a_given_torque_constant_leaves_the_current(drafted):
    assert "  current: " in drafted(beside("supply"), torque_constant=0.03).map


BOTH_WAYS = 20.0 * np.sin(3.1 * TIME) + 8.0 * np.sin(7.2 * TIME)
LOAD = 3.0 * np.sin(0.9 * TIME) + 1.0


def driving(load, speed):
    """The motor's torque that a load, inertia and friction need."""
    return 0.02 * np.gradient(speed, TIME) + 0.05 * speed + 0.5 * np.sign(speed) + load


def behind(current, torque, speed):
    return measured_behind([sampled("r", TIME, {"current": current, "motor_torque": torque, **speed})])


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("speed", [BOTH_WAYS, SPEED])
@pytest.mark.parametrize("moved", ["speed", "motor_position"])
def test_a_torque_that_explains_the_current_with_the_motion_is_behind_the_machine(sign, speed, moved):
    """The sensor may count either way, and have an offset."""
    current = noisy(driving(LOAD, speed) / 0.5, 0.02)
    motion = {moved: speed if moved == "speed" else np.cumsum(speed) * 5e-3}
    assert behind(current, noisy(sign * LOAD + 0.7, 0.02), motion) < 0.1


@pytest.mark.parametrize("kind", CURRENTS)
def test_a_motors_own_torque_is_not_behind_it(kind):
    assert behind(CURRENTS[kind], noisy(TORQUE, 0.02), {"speed": SPEED}) is None


@pytest.mark.parametrize("seed", range(20))
def test_nor_is_it_for_a_supply_or_a_magnetised_motor_at_other_speeds(seed):
    """A cube of the speed goes with its square and the speed: but then friction would push."""
    draw = np.random.default_rng(seed)
    speed = draw.uniform(100.0, 300.0) + draw.uniform(20.0, 250.0) * np.sin(draw.uniform(0.2, 2.0) * TIME)
    torque = 1e-6 * speed * np.abs(speed) + draw.uniform(0.0, 3e-4) * np.gradient(speed, TIME)
    for current in (torque * speed / 24.0 + 0.1, np.sqrt(4.0 + (torque / 0.03) ** 2)):
        assert behind(current, torque, {"speed": speed}) is None


def test_neither_is_one_that_has_nothing_to_do_with_the_current():
    current = driving(LOAD, BOTH_WAYS) / 0.5
    assert behind(current, RANDOM.standard_normal(len(TIME)), {"speed": BOTH_WAYS}) is None
    assert behind(current, noisy(LOAD, 0.02), {}) is None  # without a motion, nothing shows it


def test_operating_points_show_it_by_their_speeds():
    speed = np.repeat([-30.0, -20.0, -10.0, 10.0, 20.0, 30.0], 8)
    load = np.tile(np.linspace(0.0, 2.0, 8), 6) ** 2
    current = (0.05 * speed + 0.5 * np.sign(speed) + load) / 0.5
    signals = {"current": current, "motor_torque": load + 0.2, "speed": speed}
    points = Recording("r", np.arange(48) * 1_000_000, signals, metadata={POINTS: "yes"})
    assert not_proportional([points]) is not None and measured_behind([points]) < 1e-6


@pytest.mark.parametrize("offset", [0.5, -3.0])
def test_an_offset_of_the_torque_is_no_other_torque(offset):
    signals = {"current": noisy(TORQUE / 0.03, 0.02), "motor_torque": noisy(TORQUE, 0.02) + offset}
    assert not_proportional([sampled("r", TIME, signals)]) is None


def test_one_that_hardly_changes_tells_nothing():
    signals = {"current": noisy(TORQUE / 0.03, 0.02), "motor_torque": 1.0 + 1e-3 * RANDOM.standard_normal(len(TIME))}
    assert not_proportional([sampled("r", TIME, signals)]) is None


def dynamometer(torque="torque [Nm]", current="current [A]"):
    columns = {"time [s]": TIME, "position [rad]": np.cumsum(BOTH_WAYS) * 5e-3, "speed [rad/s]": BOTH_WAYS}
    return columns | {current: noisy(driving(LOAD, BOTH_WAYS) / 0.5, 0.01), torque: noisy(LOAD, 0.01)}


@pytest.mark.parametrize("current", ["current [A]", "motor current [A]"])
def test_on_a_dynamometer_the_current_drives_and_the_torque_is_the_load(drafted, current):
    """The current was dropped and the load's sensor taken for the drive, and no line to check."""
    draft = drafted(dynamometer(current=current))
    assert "\n  current: " in draft.map and "\n  motor_torque: " not in draft.map
    assert "# CHECK: taken for the load, measured behind the machine" in draft.line("load_torque")
    assert "torque [Nm] → load_torque in N m" in draft.said and "no line to check" not in draft.said
    assert "Assumed: torque [Nm]: taken for the load" in draft.said


def test_a_torque_named_the_motors_is_no_load(drafted):
    drawn = drafted(dynamometer(torque="motor torque [Nm]")).map
    assert "\n  motor_torque: " in drawn and "\n  load_torque: " not in drawn


@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_friction_may_be_proportional_to_the_load(friction, sign):
    """What the load leaves of the current is then no inertia and no friction of the motion alone."""
    torque = driving(LOAD, BOTH_WAYS) + friction * np.abs(LOAD) * np.sign(BOTH_WAYS)
    left = behind(noisy(torque / 0.5, 0.02), noisy(sign * LOAD, 0.02), {"speed": BOTH_WAYS})
    assert left is not None and left < 0.06


def test_friction_that_would_push_or_exceed_the_load_is_none():
    for friction in (-0.5, 1.5):
        torque = driving(LOAD, BOTH_WAYS) + friction * np.abs(LOAD) * np.sign(BOTH_WAYS)
        assert behind(torque / 0.5, LOAD, {"speed": BOTH_WAYS}) is None


def against(torque, current):
    signals = {"current": current, "motor_torque": torque, "speed": BOTH_WAYS}
    return counts_against([sampled("r", TIME, signals)])


def test_a_torque_that_falls_as_the_current_rises_is_a_load_however_much_is_left():
    wavering = 1.2 * np.sin(1.7 * TIME)  # of the friction, say
    current = noisy((driving(LOAD, BOTH_WAYS) + wavering) / 0.5, 0.02)
    assert behind(current, -LOAD, {"speed": BOTH_WAYS}) is None
    assert against(-LOAD, current) and not against(LOAD, current)
    assert not against(-LOAD - 5.0, np.abs(current))  # a current without sign does so under any negative torque


def beside_its_estimate(sensor, names=("shaft torque [Nm]", "motor torque [Nm]"), turned_order=False):
    """A load's sensor beside a torque that the drive computes from its current."""
    current = np.round((driving(LOAD, BOTH_WAYS) + 0.1 * np.abs(LOAD) * np.sign(BOTH_WAYS)) / 0.5, 4)
    torques = {names[0]: sensor, names[1]: 0.5 * current}
    columns = {"time [s]": TIME, "speed [rad/s]": BOTH_WAYS, "current [A]": current}
    return columns | (dict(reversed(torques.items())) if turned_order else torques)


@pytest.mark.parametrize("names", [("shaft torque [Nm]", "motor torque [Nm]"), ("shaft torque", "drive's torque")])
@pytest.mark.parametrize("turned_order", [False, True])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_of_two_torques_the_one_the_drive_computed_is_the_motors(drafted, names, turned_order, sign):
    """The first column was taken for the motor's, and the sensor was dropped if it came second."""
    draft = drafted(beside_its_estimate(sign * noisy(LOAD, 0.02), names, turned_order))
    assert names[1].split(" [")[0] in draft.line("motor_torque").replace("''", "'") and "\n  current:" in draft.map
    for words in ("shaft torque", "# CHECK: ", "taken for the load"):
        assert words in draft.line("load_torque")
    assert ("factor: -1" in draft.line("load_torque")) == (sign < 0.0)
    assert f"{names[0]} → load_torque" in draft.said and f"Assumed: {names[0]}: taken for the load" in draft.said


def test_a_recording_without_the_sensor_does_not_hide_it(drafted):
    current = np.round(driving(LOAD, BOTH_WAYS) / 0.5, 4)
    columns = {"time [s]": TIME, "speed [rad/s]": BOTH_WAYS, "current [A]": current, "motor torque [Nm]": 0.5 * current}
    assert "load_torque: {columns: ['torque " in drafted({**columns, "torque [Nm]": LOAD}, columns).map


def test_a_second_torque_that_is_no_load_is_not_dropped_without_a_word(drafted):
    draft = drafted(beside_its_estimate(0.3 * np.sin(0.41 * TIME + 1.0)))
    assert "\n  load_torque" not in draft.map and "motor torque" in draft.line("motor_torque")
    assert "shaft torque [Nm]: not used: motor torque [Nm] goes with current [A]" in draft.said


def test_a_second_reading_of_the_motors_torque_is_no_load(drafted):
    torque = driving(LOAD, BOTH_WAYS) + 0.1 * np.abs(LOAD) * np.sign(BOTH_WAYS)
    draft = drafted(beside_its_estimate(noisy(torque, 0.01)))
    assert "\n  load_torque" not in draft.map and "shaft torque [Nm]: not used" not in draft.said


@pytest.mark.parametrize(("current", "torque"), [(0.3, 0.25), (0.7, 1.0)])
def test_what_does_not_change_tells_no_factor(current, torque):
    """The mean of equal numbers is rounded: 4.5e15 N m/A was a perfect fit."""
    signals = {"current": np.full(1001, current), "motor_torque": np.full(1001, torque)}
    assert proportion([Recording("r", np.arange(1001) * 5_000_000, signals)]) is None

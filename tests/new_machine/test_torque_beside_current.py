"""`init` with a current and a torque: one thing in two units, a load behind the machine, or a current of a supply."""

import numpy as np
import pytest

from ema_bench_replay.recording import POINTS, Recording
from ema_twin_sim.commands.init import run as init
from ema_twin_sim.new_machine.torque_beside_current import counts_against, measured_behind, not_proportional, proportion
from tests.trace_text import write_columns

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
    recording = Recording("r", np.rint(TIME * 1e9).astype(np.int64), signals, metadata=metadata)
    own = kind in OWN and not (of_points and kind == "motor, noisy")  # rows in any order tell no noise
    assert (not_proportional([recording]) is None) == own


def test_few_rows_or_none_tell_nothing():
    stamps = np.arange(10) * 1_000_000
    few = Recording("r", stamps, {"current": np.arange(10.0), "motor_torque": np.arange(10.0) ** 2})
    assert not_proportional([few]) is None and not_proportional([]) is None
    none = Recording("r", np.arange(50) * 1_000_000, {"current": np.zeros(50), "motor_torque": np.zeros(50)})
    assert not_proportional([none]) is None


def drafted(tmp_path, kind, name="Torque (N·m)", current="Current (A)", **given):
    columns = {"Time (s)": TIME, name: TORQUE, current: CURRENTS[kind], "Speed (rad/s)": SPEED}
    init(str(tmp_path / "m"), [write_columns(tmp_path / "run.csv", columns)], **given)
    return (tmp_path / "m_map.yaml").read_text()


@pytest.mark.parametrize("kind", ["motor", "supply", "magnetising"])
def test_the_torque_is_used_and_said_if_the_current_is_not_the_motors(tmp_path, capsys, kind):
    drawn = drafted(tmp_path, kind)
    told = " ".join(capsys.readouterr().out.split())
    assert "  motor_torque: " in drawn
    assert ("  current: " in drawn) == (kind == "motor")
    assert ("Current (A): not used: Torque (N·m) is not proportional to it" in told) == (kind != "motor")
    assert ("torque constant 30.0 mN m/A (torque over current" in told) == (kind == "motor")
    line = next(line for line in drawn.splitlines() if line.startswith("  motor_torque: "))
    assert ("# CHECK: used in place of the current, to which it is not proportional" in line) == (kind != "motor")


@pytest.mark.parametrize("name", ["load torque [N m]", "torque sensor [N m]", "brake torque [N m]", "torque"])
def test_a_torque_named_a_load_or_without_a_unit_leaves_the_current(tmp_path, name):
    assert "  current: " in drafted(tmp_path, "supply", name)


@pytest.mark.parametrize("name", ["motor current [A]", "iq [A]", "I_q [A]", "Motorstrom [A]"])
def test_a_current_named_the_motors_is_used(tmp_path, name):
    assert "  current: " in drafted(tmp_path, "magnetising", current=name)


def test_a_given_torque_constant_leaves_the_current(tmp_path):
    assert "  current: " in drafted(tmp_path, "supply", torque_constant=0.03)


BOTH_WAYS = 20.0 * np.sin(3.1 * TIME) + 8.0 * np.sin(7.2 * TIME)
LOAD = 3.0 * np.sin(0.9 * TIME) + 1.0
STAMPS = np.rint(TIME * 1e9).astype(np.int64)


def driving(load, speed, inertia=0.02):
    """The motor's torque that a load, inertia and friction need."""
    return inertia * np.gradient(speed, TIME) + 0.05 * speed + 0.5 * np.sign(speed) + load


def behind(current, torque, speed):
    return measured_behind([Recording("r", STAMPS, {"current": current, "motor_torque": torque, **speed})])


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
    assert not_proportional([Recording("r", STAMPS, signals)]) is None


def test_one_that_hardly_changes_tells_nothing():
    signals = {"current": noisy(TORQUE / 0.03, 0.02), "motor_torque": 1.0 + 1e-3 * RANDOM.standard_normal(len(TIME))}
    assert not_proportional([Recording("r", STAMPS, signals)]) is None


def dynamometer(tmp_path, torque="torque [Nm]", current="current [A]"):
    columns = {"time [s]": TIME, "position [rad]": np.cumsum(BOTH_WAYS) * 5e-3, "speed [rad/s]": BOTH_WAYS}
    columns |= {current: noisy(driving(LOAD, BOTH_WAYS) / 0.5, 0.01), torque: noisy(LOAD, 0.01)}
    init(str(tmp_path / "m"), [write_columns(tmp_path / "run.csv", columns)])
    return (tmp_path / "m_map.yaml").read_text().splitlines()


@pytest.mark.parametrize("current", ["current [A]", "motor current [A]"])
def test_on_a_dynamometer_the_current_drives_and_the_torque_is_the_load(tmp_path, capsys, current):
    """The current was dropped and the load's sensor taken for the drive, and nothing had to be guessed."""
    drawn = dynamometer(tmp_path, current=current)
    told = " ".join(capsys.readouterr().out.split())
    assert any(line.startswith("  current: ") for line in drawn)
    assert not any(line.startswith("  motor_torque: ") for line in drawn)
    line = next(line for line in drawn if line.startswith("  load_torque: "))
    assert "# CHECK: taken for the load, measured behind the machine" in line
    assert "torque [Nm] → load_torque in N m" in told and "nothing had to be guessed" not in told
    assert "Assumed: torque [Nm]: taken for the load" in told


def test_a_torque_named_the_motors_is_no_load(tmp_path):
    drawn = dynamometer(tmp_path, torque="motor torque [Nm]")
    assert any(line.startswith("  motor_torque: ") for line in drawn)
    assert not any(line.startswith("  load_torque: ") for line in drawn)


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
    return counts_against([Recording("r", STAMPS, signals)])


def test_a_torque_that_falls_as_the_current_rises_is_a_load_however_much_is_left():
    wavering = 1.2 * np.sin(1.7 * TIME)  # of the friction, say
    current = noisy((driving(LOAD, BOTH_WAYS) + wavering) / 0.5, 0.02)
    assert behind(current, -LOAD, {"speed": BOTH_WAYS}) is None
    assert against(-LOAD, current) and not against(LOAD, current)
    assert not against(-LOAD - 5.0, np.abs(current))  # a current without sign does so under any negative torque


def beside_its_estimate(tmp_path, sensor, names=("shaft torque [Nm]", "motor torque [Nm]"), turned_order=False):
    """`init` on a load's sensor beside a torque that the drive computes from its current; the map's signals."""
    current = np.round((driving(LOAD, BOTH_WAYS) + 0.1 * np.abs(LOAD) * np.sign(BOTH_WAYS)) / 0.5, 4)
    torques = {names[0]: sensor, names[1]: 0.5 * current}
    columns = {"time [s]": TIME, "speed [rad/s]": BOTH_WAYS, "current [A]": current}
    columns |= dict(reversed(torques.items())) if turned_order else torques
    init(str(tmp_path / "m"), [write_columns(tmp_path / "run.csv", columns)])
    lines = (tmp_path / "m_map.yaml").read_text().splitlines()
    return {line.split(":")[0].strip(): line for line in lines if line.startswith("  ")}


@pytest.mark.parametrize("names", [("shaft torque [Nm]", "motor torque [Nm]"), ("shaft torque", "drive's torque")])
@pytest.mark.parametrize("turned_order", [False, True])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_of_two_torques_the_one_the_drive_computed_is_the_motors(tmp_path, capsys, names, turned_order, sign):
    """The first column was taken for the motor's, and the sensor was dropped if it came second."""
    drawn = beside_its_estimate(tmp_path, sign * noisy(LOAD, 0.02), names, turned_order)
    assert names[1].split(" [")[0] in drawn["motor_torque"].replace("''", "'")
    assert "shaft torque" in drawn["load_torque"] and "current" in drawn
    assert "# CHECK: " in drawn["load_torque"] and "taken for the load" in drawn["load_torque"]
    assert ("factor: -1" in drawn["load_torque"]) == (sign < 0.0)
    told = " ".join(capsys.readouterr().out.split())
    assert f"{names[0]} → load_torque" in told and f"Assumed: {names[0]}: taken for the load" in told


def test_a_recording_without_the_sensor_does_not_hide_it(tmp_path):
    current = np.round(driving(LOAD, BOTH_WAYS) / 0.5, 4)
    columns = {"time [s]": TIME, "speed [rad/s]": BOTH_WAYS, "current [A]": current, "motor torque [Nm]": 0.5 * current}
    without = write_columns(tmp_path / "without.csv", columns)
    init(str(tmp_path / "m"), [write_columns(tmp_path / "run.csv", {**columns, "torque [Nm]": LOAD}), without])
    assert "load_torque: {columns: ['torque " in (tmp_path / "m_map.yaml").read_text()


def test_a_second_torque_that_is_no_load_is_not_dropped_without_a_word(tmp_path, capsys):
    drawn = beside_its_estimate(tmp_path, 0.3 * np.sin(0.41 * TIME + 1.0))
    assert "load_torque" not in drawn and "motor torque" in drawn["motor_torque"]
    told = " ".join(capsys.readouterr().out.split())
    assert "shaft torque [Nm]: not used: motor torque [Nm] goes with current [A]" in told


def test_a_second_reading_of_the_motors_torque_is_no_load(tmp_path, capsys):
    torque = driving(LOAD, BOTH_WAYS) + 0.1 * np.abs(LOAD) * np.sign(BOTH_WAYS)
    drawn = beside_its_estimate(tmp_path, noisy(torque, 0.01))
    assert "load_torque" not in drawn
    assert "shaft torque [Nm]: not used" not in " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize(("current", "torque"), [(0.3, 0.25), (0.7, 1.0)])
def test_what_does_not_change_tells_no_factor(current, torque):
    """The mean of equal numbers is rounded: 4.5e15 N m/A was a perfect fit."""
    signals = {"current": np.full(1001, current), "motor_torque": np.full(1001, torque)}
    assert proportion([Recording("r", np.arange(1001) * 5_000_000, signals)]) is None

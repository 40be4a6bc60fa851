"""`init` with a current and a torque: if they are not proportional, the torque is used, unless it is named a load."""

import numpy as np
import pytest

from ema_bench_replay.recording import POINTS, Recording
from ema_twin_sim.commands.init import run as init
from ema_twin_sim.new_machine.torque_beside_current import not_proportional

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
    rows = "\n".join(",".join(f"{value:.9g}" for value in row) for row in zip(*columns.values(), strict=True))
    (tmp_path / "run.csv").write_text(",".join(columns) + "\n" + rows + "\n")
    init(str(tmp_path / "m"), [tmp_path / "run.csv"], **given)
    return (tmp_path / "m_map.yaml").read_text()


@pytest.mark.parametrize("kind", ["motor", "supply", "magnetising"])
def test_the_torque_is_used_and_said_if_the_current_is_not_the_motors(tmp_path, capsys, kind):
    drawn = drafted(tmp_path, kind)
    told = " ".join(capsys.readouterr().out.split())
    assert "  motor_torque: " in drawn
    assert ("  current: " in drawn) == (kind == "motor")
    assert ("Current (A): not used: Torque (N·m) is not proportional to it" in told) == (kind != "motor")
    assert ("torque constant 1.00 N m/A" in told) == (kind == "motor")


@pytest.mark.parametrize("name", ["load torque [N m]", "torque sensor [N m]", "brake torque [N m]", "torque"])
def test_a_torque_named_a_load_or_without_a_unit_leaves_the_current(tmp_path, name):
    assert "  current: " in drafted(tmp_path, "supply", name)


@pytest.mark.parametrize("name", ["motor current [A]", "iq [A]", "I_q [A]", "Motorstrom [A]"])
def test_a_current_named_the_motors_is_used(tmp_path, name):
    assert "  current: " in drafted(tmp_path, "magnetising", current=name)


def test_a_given_torque_constant_leaves_the_current(tmp_path):
    assert "  current: " in drafted(tmp_path, "supply", torque_constant=0.03)

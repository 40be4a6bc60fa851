"""The wavelength by default: one turn of the motor, wherever the recordings or a model show it."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from ema_bench_replay.recording import AT, Recording
from ema_twin_sim.campaign.turn_of_motor import turn_of_motor
from ema_twin_sim.health import MotionRecord
from tests.command_line import done_here

TURN = 2.0 * math.pi
TIME = np.arange(0.0, 10.0, 0.01)
WAY = 40.0 * np.sin(0.6 * TIME)  # rad of the motor
CURRENT = np.sign(np.cos(0.6 * TIME)) + 0.01 * np.random.default_rng(1).normal(size=len(TIME))


def default(signals, model=None, **metadata):
    stamps = np.round(TIME * 1e9).astype(np.int64)
    recording = Recording("run", stamps, {"current": CURRENT, **signals}, metadata=metadata)
    return turn_of_motor(MotionRecord.from_recording(recording, "test"), model, recording)


def test_a_motors_own_angle_shows_its_turn():
    assert default({"motor_position": WAY}) == (TURN, "")


def test_an_angle_that_the_map_says_is_the_outputs_shows_no_turn_of_the_motor():
    found, said = default({"motor_position": WAY}, **{f"motor_position{AT}": "output"})
    assert math.isnan(found) and "the output's angle alone" in said and "--model" in said
    model = SimpleNamespace(value=lambda path: {"machine.gear_ratio": 20.0}[path])
    assert default({"motor_position": WAY}, model, **{f"motor_position{AT}": "output"}) == (TURN / 20.0, "")


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_both_encoders_show_the_turn_of_the_motor(sign):
    play = 1e-3 * np.sign(np.cos(0.6 * TIME))
    found, said = default({"motor_position": WAY, "output_position": sign * (WAY / 50.0 + play)})
    assert found == pytest.approx(TURN / 50.0, rel=1e-12) and not said


def test_a_ratio_that_is_no_whole_number_is_told_with_its_wavelength():
    found, said = default({"motor_position": WAY, "output_position": WAY / 12.5})
    assert math.isnan(found) and "12.5, is no whole number" in said and "--wavelength 0.5027" in said


def test_what_all_units_lack_is_told_once(tmp_path, capsys):
    for unit in ("A", "B"):
        (tmp_path / "rigs" / unit).mkdir(parents=True)
        for day in range(1, 4):
            columns = np.column_stack([TIME, WAY / 50.0, CURRENT])
            np.savetxt(
                tmp_path / "rigs" / unit / f"2024-01-0{day}.csv", columns, delimiter=",", comments="",
                header="time [s],angle [rad],current [A]",
            )  # fmt: skip
    (tmp_path / "map.yaml").write_text(
        "version: 1\ntime: {column: 'time \\[s\\]', unit: s}\nsignals:\n"
        "  output_position: {columns: ['angle \\[rad\\]'], unit: rad}\n"
        "  current: {columns: ['current \\[A\\]'], unit: A}\n"
    )
    done_here("campaign", tmp_path / "rigs", "--do", "health", "--map", tmp_path / "map.yaml", "-o", tmp_path / "r",
              "--workers", 1)  # fmt: skip
    assert capsys.readouterr().err.count("no wave that repeats with the position is judged") == 1

"""A table of operating points that is judged in two halves is one recording: what is wrong with it is told once."""

from dataclasses import replace

import numpy as np
import pytest

from ema_bench_replay.recording import POINTS, Recording
from ema_twin_sim.measured.folds import operating_point_folds
from ema_twin_sim.model import load_model


@pytest.mark.parametrize("placed", [True, False])
def test_warnings_of_the_whole_are_told_once(placed):
    count = 120
    signals = {"motor_torque": np.linspace(-1.0, 1.0, count), "speed": np.linspace(-9.0, 9.0, count)}
    if placed:
        signals["motor_position"] = np.linspace(0.0, 6.0, count)
    table = Recording("points", np.arange(count) * 10**9, signals, metadata={POINTS: "true"})
    halves = operating_point_folds([replace(table, warnings=("points: a row is missing",))], load_model("laas_motor"))
    assert len(halves) == 2
    assert [warning for half in halves for warning in half.warnings] == ["points: a row is missing"]

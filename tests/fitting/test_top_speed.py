"""The top speed that fitted values are held against: the machine's, however coarse its counter is."""

import numpy as np
import pytest

from ema_bench_replay.recording import POINTS, Recording
from ema_twin_sim.fitting.plausibility import top_speed

TIME = np.arange(0.0, 10.0, 1e-3)
FASTEST = 3.0  # rad/s
SWINGS = 3.0 * np.sin(TIME)


def counted(counts):
    step = 2.0 * np.pi / counts
    stamps = np.rint(TIME * 1e9).astype(np.int64)
    return Recording("run", stamps, {"motor_position": step * np.floor(SWINGS / step)})


@pytest.mark.parametrize("counts", [200, 4096, 2**20])
def test_a_coarse_counter_makes_no_machine_fast(stock, counts):
    """At 1 kHz a step of a counter of 200 lines would be 31 rad/s."""
    model = stock.with_value("sensors.motor_encoder_counts", float(counts))
    assert top_speed(counted(counts), model) == pytest.approx(FASTEST, rel=0.04)


def test_gaps_and_measured_speeds(stock):
    run = counted(2**20)
    position = run.signals["motor_position"].copy()
    position[3000:3050] = np.nan
    run = Recording("gap", run.stamps, {"motor_position": position})
    assert top_speed(run, stock) == pytest.approx(FASTEST, rel=0.04)
    measured = Recording("run", run.stamps, {"motor_position": SWINGS, "speed": np.r_[np.nan, np.full(9999, -7.0)]})
    assert top_speed(measured, stock) == 7.0


def test_points_are_no_motion(stock):
    """From one point to the next nothing moved in the time between their rows."""
    stamps = np.arange(len(TIME)) * 1000
    signals = {"motor_position": SWINGS, "speed": np.full(len(TIME), 2.0), "current": np.ones(len(TIME))}
    assert top_speed(Recording("points", stamps, signals, metadata={POINTS: "yes"}), stock) == 2.0
    del signals["speed"]
    assert top_speed(Recording("points", stamps, signals, metadata={POINTS: "yes"}), stock) < 0.1

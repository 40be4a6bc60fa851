"""The noise of operating points: that of their readings, in whatever order a table has its rows."""

import numpy as np
import pytest

from ema_bench_replay.recording import POINTS, Recording
from ema_twin_sim.measured.observe import observe
from ema_twin_sim.measured.scales import to_own_units

NOISE = 0.003  # N m


def table(order):
    """A friction curve of a motor in both directions, its rows in an ``order``."""
    speed = np.concatenate([np.linspace(-20.0, -1.0, 100), np.linspace(1.0, 20.0, 100)])
    torque = 0.1 * np.sign(speed) + 0.02 * speed + NOISE * np.random.default_rng(3).standard_normal(len(speed))
    signals = {"motor_torque": torque, "speed": speed}
    stamps = np.arange(len(speed)) * 10**9
    return Recording("curve", stamps, {k: v[order] for k, v in signals.items()}, metadata={POINTS: "true"})


def row_noise(recording, model):
    (own, *_), its_model = to_own_units([recording], model)
    return float(np.median(observe(own, its_model).torque_noise))


def test_rows_in_any_order_have_the_noise_of_their_readings(motor):
    """Between rows that do not follow each other the torque itself changes; that is no noise."""
    swept = row_noise(table(np.arange(200)), motor)
    assert row_noise(table(np.random.default_rng(8).permutation(200)), motor) == pytest.approx(swept, rel=0.05)

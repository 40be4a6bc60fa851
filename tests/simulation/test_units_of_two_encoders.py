"""The unit of time of a machine recorded with two encoders alone: from its speed, and no shorter than its samples."""

import numpy as np
import pytest

from ema_bench_replay.recording import Recording
from ema_twin_sim.model import reference_bench
from ema_twin_sim.simulation.behind_motor import typical_units

COUNT = 2000


def turning(speed, period):
    """A motor that swings, by so many rad/s (root mean square), and its output; ``period`` in ms."""
    stamps = np.arange(COUNT) * int(period * 1e6)
    rate = 2.0 * np.pi / (400 * period * 1e-3)
    position = np.sqrt(2.0) * speed / rate * np.sin(rate * stamps * 1e-9)
    return Recording("turning", stamps, {"motor_position": position, "output_position": position})


@pytest.mark.parametrize(("speed", "unit"), [(6.9, 1.0), (69.0, 0.1), (690.0, 0.1)])
def test_a_machine_too_fast_for_its_samples_has_a_longer_one(speed, unit, stock):
    """At 1 kHz, a tenth of a second makes the samples as close as the reference bench's at 10 ms."""
    units = typical_units([turning(speed, 1)], stock)
    assert units.time == pytest.approx(unit, rel=0.01)
    assert 1e-3 / units.time <= 1.001 * reference_bench.LONGEST_PERIOD
    inertia = sum(stock.value(f"machine.{part}_inertia") for part in ("motor", "gearbox", "output"))
    assert units.torque * units.time**2 == pytest.approx(inertia / reference_bench.INERTIA)

"""A recording that begins while its setpoint jumps: the twin's controller starts as the drive's was."""

import math
from dataclasses import replace

import numpy as np
import pytest

from ema_bench_replay.recording import Recording
from ema_twin_sim.simulation.simulate import simulate


def square(speed, seconds=4.0, period=1.0):
    """A setpoint that jumps to and fro, as a recording of it alone; it begins at rest."""
    stamps = np.arange(round(seconds / 2e-3)) * 2_000_000
    time = stamps * 1e-9
    asked = np.where(time < 0.5, 0.0, np.where(((time - 0.5) / period) % 2.0 < 1.0, speed, -speed))
    rest = np.zeros(len(stamps))
    return Recording("square", stamps, {"speed_setpoint": asked, "speed": rest, "current": rest})


@pytest.fixture(scope="module")
def bench(stock):
    """What a drive of the model's own does, its sensors without noise."""
    asked = square(3.0)
    return replace(simulate(stock, asked, "setpoint"), name="bench")


@pytest.mark.parametrize("late", [0, 1, 2, 5])
@pytest.mark.parametrize("jump", [0.5, 1.5])
def test_the_integrator_holds_what_the_gain_does_not_make(stock, bench, jump, late):
    """From the jump itself, before the drive answers, and from some samples after it, while its current is highest."""
    asked = square(3.0)
    held = dict(bench.signals) | {"speed_setpoint": asked.signals["speed_setpoint"]}
    part = replace(bench, signals=held).between(jump + late * 2e-3)
    twin = simulate(stock, part, "setpoint")
    missed = twin.signals["motor_position"] - part.signals["motor_position"]
    travel = float(np.ptp(part.signals["motor_position"]))
    assert float(np.abs(missed).max()) < 0.011 * travel
    assert math.isfinite(travel) and travel > 1.0

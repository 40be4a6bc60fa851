"""Memory holds what is recorded, and nothing of the time in between."""

import multiprocessing
import resource
import sys

import numpy as np
import pytest

from ema_twin_sim import load_model
from ema_twin_sim.plant.layout import BENCH
from ema_twin_sim.simulation.twin import Twin

UNIT = 2**20 if sys.platform == "darwin" else 2**10  # of ru_maxrss to a MiB
TIMES = {"polito_bench": (1.0, 10.0, 100.0, 1000.0), "polito_hff": (0.1, 1.0, 10.0)}
GROWTH = 1.0  # MiB, a page here and there


def peaks(name):
    """The most memory [MiB] that this process has had after each of the times; only the last row is recorded."""
    bench = np.full((2, len(BENCH)), np.nan)
    bench[:, BENCH.index("speed_setpoint")] = 5.0
    twin = Twin(load_model(name), "setpoint")
    found = []
    for seconds in TIMES[name]:
        twin.start({"speed": 5.0, "speed_setpoint": 5.0})
        twin.follow(np.array([0, round(seconds * 1e9)]), bench)
        found.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / UNIT)
    return found


@pytest.mark.timeout(600)
@pytest.mark.parametrize("name", TIMES)
def test_memory_does_not_grow_with_the_simulated_time(name, say):
    Twin(load_model(name))  # the process that measures must not compile: that takes more than any simulation
    with multiprocessing.get_context("spawn").Pool(1) as fresh:
        found = fresh.apply(peaks, (name,))
    say(f"\n  {name + ', last row recorded':<46}{'simulated s':>12}{'peak MiB':>10}")
    for seconds, most in zip(TIMES[name], found, strict=True):
        say(f"  {'':<46}{seconds:>12g}{most:>10.1f}")
    assert found[-1] - found[0] <= GROWTH

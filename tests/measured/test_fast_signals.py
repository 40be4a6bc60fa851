"""Signals that change as fast as noise: what third differences take for noise is not all of it."""

import numpy as np
import pytest

from ema_twin_sim.measured.row_noise import torque_noise
from ema_twin_sim.measured.smoothing import gaussian
from ema_twin_sim.model import load_model
from ema_twin_sim.reading_noise import beside_fast_signal, drowns, reading_noise

PERIOD = 1e-3
TIME = np.arange(4000) * PERIOD


def white(size, seed=3, count=4000):
    return size * np.random.default_rng(seed).standard_normal(count)


def told(values):
    return beside_fast_signal(reading_noise(values), values)


SINE = np.sin(2.0 * np.pi * 400.0 * TIME)
SWEEP = 1.4 * np.sin(2.0 * np.pi * (200.0 * TIME + 0.5 * 280.0 / TIME[-1] * TIME**2))
"""Nearly as fast as samples can follow."""


@pytest.mark.parametrize("fast", [SINE, SWEEP], ids=["sine", "sweep"])
@pytest.mark.parametrize("noise", [0.02, 0.1])
def test_a_fast_signal_is_quiet_at_most_frequencies_most_of_the_time(fast, noise):
    read = fast + white(noise)
    assert reading_noise(read) > np.std(read)
    assert told(read) == pytest.approx(noise, rel=0.15)


@pytest.mark.parametrize("count", [200, 1000, 4000])
@pytest.mark.parametrize("seed", range(5))
def test_noise_alone_stays_what_it_is(seed, count):
    alone = white(0.3, seed, count)
    assert told(alone) == reading_noise(alone) and drowns(reading_noise(alone), alone)


def test_a_slow_signal_is_not_looked_at():
    slow = np.sin(2.0 * np.pi * 3.0 * TIME) + white(0.05)
    assert told(slow) == reading_noise(slow) and not drowns(reading_noise(slow), slow)
    assert not drowns(0.0, slow)


def test_the_rows_of_a_fast_current_are_told_their_own_noise():
    """A third difference hid the torque of a swept motor in a noise larger than the torque itself."""
    model = load_model("laas_motor")
    kernel = gaussian(0.005, PERIOD)
    fast = SINE + white(0.02)
    expected = model.value("machine.torque_constant") * 0.02 * np.linalg.norm(kernel)
    assert torque_noise(fast, fast, kernel, model) == pytest.approx(expected, rel=0.15)

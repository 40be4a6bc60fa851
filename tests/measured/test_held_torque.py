"""A current that the log repeats is told; one that is only coarse, or that is set in steps, is not."""

import numpy as np
import pytest

from ema_twin_sim.measured.held_torque import samples_repeated, telling_repeats
from tests.recorded import sampled

TIME = np.arange(4000) * 1e-3
TORQUE = 2.0 * np.sin(7.0 * TIME) + 0.3 * np.sin(41.0 * TIME)


def logged(current):
    return sampled("a", TIME, {"motor_position": np.sin(7.0 * TIME), "current": current})


def read_every(samples):
    """A noisy current (n,) [A] that is read once in so many samples, on average."""
    noisy = TORQUE + np.random.default_rng(1).normal(0.0, 0.02, len(TIME))
    return noisy[(np.floor(np.arange(len(TIME)) / samples) * samples).astype(int)]


@pytest.mark.parametrize("samples", [2, 7.5, 15])
def test_a_current_that_is_read_less_often_than_logged_is_told_with_its_delay(samples):
    told = telling_repeats(logged(read_every(samples))).warnings
    assert samples_repeated(logged(read_every(samples)), "current") == pytest.approx(samples, rel=0.02)
    assert len(told) == 1 and f"once in {samples:.2g} samples" in told[0]
    assert f"{0.5 * (samples - 1):.2g} ms late" in told[0]


@pytest.mark.parametrize(
    "current",
    [
        TORQUE + np.random.default_rng(1).normal(0.0, 0.02, len(TIME)),
        np.round(TORQUE, 1),  # a coarse reading that changes slowly
        np.round(TORQUE + np.random.default_rng(1).normal(0.0, 0.02, len(TIME)), 1),
        np.round(3.0 * TIME, 2),  # which changes by a count in every third sample
        np.where(np.mod(TIME, 1.0) < 0.5, 1.0, -1.0),  # steps
    ],
)
def test_a_coarse_current_or_one_in_steps_is_none(current):
    assert telling_repeats(logged(current)).warnings == ()

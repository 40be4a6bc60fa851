"""How narrow a kernel may be: as the motion's own acceleration allows, wherever the recording begins and ends."""

import numpy as np
import pytest

from ema_twin_sim.measured.bandwidth import narrowest, narrowest_of_speed, slope
from ema_twin_sim.measured.smoothing import smooth

PERIOD, WIDEST = 1e-3, 0.012
COUNT = 2.0 * np.pi / 65536.0


def width(position):
    """The narrowest kernel for a position (n,) as its counter reads it."""
    read = COUNT * np.rint(position / COUNT)
    return narrowest(read, PERIOD, COUNT / np.sqrt(12.0), WIDEST, 2.5 * PERIOD)


@pytest.mark.parametrize("speed", [6.9, -20.0])
def test_a_constant_speed_has_no_acceleration_at_its_ends(speed):
    """The motor turned before the recording began, and goes on turning after it: no narrow kernel is of use."""
    assert width(speed * PERIOD * np.arange(5000)) == WIDEST


def test_a_swing_about_a_constant_speed_is_seen_as_without_it():
    time = PERIOD * np.arange(5000)
    swing = 0.05 * np.sin(2.0 * np.pi * 3.0 * time)
    assert width(swing) < WIDEST
    assert width(swing + 6.9 * time) == width(swing)


@pytest.mark.parametrize("smoothing", [0.0, 2e-3])
def test_a_quiet_speed_needs_no_wide_kernel_and_a_noisy_one_does(smoothing):
    speed = 4.0 * np.sin(2.0 * np.pi * 3.0 * PERIOD * np.arange(5000))
    widths = [
        narrowest_of_speed(speed, PERIOD, noise, smoothing, WIDEST, 2.5 * PERIOD) for noise in (1e-4, 0.02, 0.2, 20.0)
    ]
    assert widths == sorted(widths) and widths[-1] == WIDEST
    assert widths[0] == pytest.approx(2.5 * PERIOD, rel=0.45)


@pytest.mark.parametrize("held", [2, 10, 20])
def test_a_speed_that_is_logged_more_often_than_it_changes_keeps_its_acceleration(held):
    """Its stairs are no noise of single readings; a kernel narrower than a stair would see spikes."""
    period = 1e-4
    time = period * np.arange(20_000)
    rate = 2.0 * np.pi * 3.0
    speed = (4.0 * np.sin(rate * time) + np.random.default_rng(1).normal(0.0, 1e-4, len(time)))[::held].repeat(held)
    found = narrowest_of_speed(speed, period, 1e-4, 0.0, 50.0 * period, 2.5 * period)
    late = 0.5 * (held - 1) * period
    off = smooth(speed, slope(found, period, 0.0)) - 4.0 * rate * np.cos(rate * (time - late))
    assert np.std(off[1000:-1000]) < 0.05 * 4.0 * rate

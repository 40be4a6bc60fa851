"""How narrow a kernel may be: as the motion's own acceleration allows, wherever the recording begins and ends."""

import numpy as np
import pytest

from ema_twin_sim.measured.bandwidth import narrowest, narrowest_of_speed

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

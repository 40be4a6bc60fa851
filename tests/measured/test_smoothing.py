"""Kernels that differentiate as they smooth."""

import numpy as np
import pytest

from ema_twin_sim.measured.smoothing import gaussian


@pytest.mark.parametrize("widths", [0.1, 0.5, 1.0], ids=lambda widths: f"{widths} widths")
@pytest.mark.parametrize("samples", [2.5, 10.0, 40.0], ids=lambda samples: f"{samples} samples wide")
def test_what_swings_is_differentiated_as_it_is_smoothed(samples, widths):
    """Of a swing whose radian takes so many standard deviations, within 1e-3 whatever its quickness."""
    turn = widths / samples  # rad a sample

    def passed(order):
        kernel = gaussian(samples, 1.0, order)
        half = len(kernel) // 2
        # time reversed: np.convolve turns the kernel round
        return complex(np.exp(-1j * turn * np.arange(-half, half + 1)) @ kernel)

    assert passed(1) / passed(0) == pytest.approx(1j * turn, rel=1.5e-3)
    assert passed(2) / passed(0) == pytest.approx(-(turn**2), rel=1.5e-3)

"""Windows that slide over samples, beside scipy's."""

import numpy as np
import pytest
from scipy.ndimage import maximum_filter1d, median_filter

from ema_twin_sim.measured.sliding import moving_maximum, moving_median


@pytest.mark.parametrize("count", [1, 2, 30, 31, 400])
@pytest.mark.parametrize(("before", "after"), [(0, 0), (3, 3), (25, 10), (10, 25), (500, 5)])
def test_a_moving_maximum_is_that_of_scipy_at_the_ends_too(count, before, after):
    values = np.random.default_rng(count).normal(size=count)
    expected = maximum_filter1d(values, before + after + 1, origin=(before - after) // 2)
    np.testing.assert_array_equal(moving_maximum(values, before, after), expected)


@pytest.mark.parametrize("count", [1, 3, 7, 400])
def test_a_moving_median_is_that_of_scipy_at_the_ends_too(count):
    values = np.random.default_rng(count).normal(size=count)
    np.testing.assert_array_equal(moving_median(values, 7), median_filter(values, 7))

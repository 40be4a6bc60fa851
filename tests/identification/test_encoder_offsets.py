"""Offsets of the encoders' rows."""

import numpy as np
import pytest

from ema_twin_sim.identification.encoder_offsets import remove_offsets


@pytest.mark.parametrize("seed", range(5))
def test_offsets_begin_at_the_median_of_any_number_of_rows(seed):
    rng = np.random.default_rng(seed)
    for count in (*range(1, 40), 1000):
        rows = np.concatenate([rng.normal(size=3), np.round(rng.standard_cauchy(count), 1)])  # with equal values
        noise, scale = rng.uniform(0.5, 2.0, count), np.full(count + 3, 1e-6)
        part = rows[3:] - np.median(rows[3:] * noise) / noise
        weights = 1.0 / (1.0 + (part / 1e-6) ** 2) / noise
        expected = part - (weights @ part) / (weights @ (1.0 / noise)) / noise
        before = rows[:3].copy()
        remove_offsets(rows, np.array([[3, count + 3]]), 3, noise, scale)
        np.testing.assert_allclose(rows[3:], expected, rtol=1e-12, atol=1e-9)
        assert np.array_equal(rows[:3], before)

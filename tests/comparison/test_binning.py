"""Bins: quartiles of the values in each."""

import numpy as np
import pytest

from ema_twin_sim.comparison.binning import bin_edges, quartiles, rows_by_bin


@pytest.mark.parametrize("fewest", [1, 2, 5])
def test_quartiles_of_bins_are_those_of_numpy(fewest):
    rng = np.random.default_rng(3)
    x, values = rng.normal(size=(2, 400))
    rows = rows_by_bin(x, bin_edges(x, 40, narrow=True), fewest)
    assert rows and min(map(len, rows)) == fewest
    for found, expected in zip(quartiles(values, rows), (0.25, 0.5, 0.75), strict=True):
        assert found == pytest.approx([np.quantile(values[inside], expected) for inside in rows], rel=1e-12, abs=1e-15)


def test_without_bins_there_are_no_quartiles():
    assert [len(part) for part in quartiles(np.zeros(3), [])] == [0, 0, 0]

"""Random effects: the probability that a healthy run is as far off is that of Hotelling's T²."""

import numpy as np
import pytest
from scipy import stats

from ema_twin_sim.health.between_tests import predict


def test_the_tail_is_that_of_hotelling_also_for_some_of_the_features():
    rng = np.random.default_rng(1)
    tests = [f"test {k // 3}" for k in range(30)]
    prediction = predict(rng.normal(size=(30, 4)) + np.repeat(rng.normal(size=(10, 4)), 3, axis=0), tests)
    for rows in ([0], [1, 3], [0, 1, 2, 3]):
        part, values = prediction.part(rows), 3.0 * rng.normal(size=len(rows))
        freedom, count = part.degrees_of_freedom, len(rows)
        left = freedom - count + 1.0
        off = values - prediction.mean[rows]
        square = off @ np.linalg.solve(prediction.covariance[np.ix_(rows, rows)], off)
        expected = stats.f.logsf(square * left / (count * freedom), count, left)
        assert part.tail(values) == pytest.approx(expected, rel=1e-9)
        assert prediction.part(rows) is part
    assert prediction.part([0]).tail(np.array([1e100])) == -np.inf

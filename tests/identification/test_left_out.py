"""What a solution moves by without some of its rows: one rule for the standard errors of both verbs."""

import numpy as np
import pytest

from ema_twin_sim.identification.uncertainty import move_without


def test_it_is_the_solution_of_the_other_rows():
    """Of a linear problem, first order is all there is: leaving rows out and fitting anew give the same."""
    random = np.random.default_rng(3)
    slopes, measured = random.normal(size=(40, 3)), random.normal(size=40)
    inverse = np.diag([0.5, 2.0, 0.1])  # priors, at zero

    def solved(rows):
        return np.linalg.solve(slopes[rows].T @ slopes[rows] + inverse**2, slopes[rows].T @ measured[rows])

    every, kept = np.arange(40), np.arange(10, 40)
    whole = solved(every)
    residual = measured - slopes @ whole
    moved = move_without(slopes.T @ slopes + inverse**2, slopes[:10], residual[:10])
    assert whole + moved == pytest.approx(solved(kept), rel=1e-9)

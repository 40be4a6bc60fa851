"""The Cramér–Rao bound of rows whose noise is correlated, on rows made by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from ema_twin_sim.identification.cramer_rao import cramer_rao, fisher_information
from ema_twin_sim.identification.equation import EquationErrorProblem
from ema_twin_sim.identification.null_hypothesis import null_hypothesis
from tests.few_rows import few_rows

ROWS = 4000


def noise(correlation, count=ROWS, seed=3):
    """Noise of unit variance, each row so much like the one before."""
    random = np.random.default_rng(seed)
    steps = random.normal(size=count) * np.sqrt(1.0 - correlation**2)
    steps[0] = random.normal()
    found = np.zeros(count)
    for k in range(count):
        found[k] = correlation * found[k - 1] * (k > 0) + steps[k]
    return found


@pytest.mark.parametrize("correlation", [0.0, 0.5, 0.8])
def test_of_a_constant_what_correlated_rows_tell(correlation):
    """Of the mean of n rows that are each correlated by ρ with the next, as much as n (1 − ρ) / (1 + ρ) others."""
    problem = EquationErrorProblem([few_rows(np.zeros(ROWS))])
    (told,) = fisher_information(problem, noise(correlation), np.ones((ROWS, 1))).ravel()
    assert told == pytest.approx(ROWS * (1.0 - correlation) / (1.0 + correlation), rel=0.2)


def test_of_what_changes_from_row_to_row_correlated_noise_tells_more():
    """What changes its sign with every row is seen the better, the more alike neighbouring noise is."""
    problem = EquationErrorProblem([few_rows(np.zeros(ROWS))])
    turns = np.where(np.arange(ROWS) % 2, 1.0, -1.0)[:, None]
    white, alike = (fisher_information(problem, noise(c), turns)[0, 0] for c in (0.0, 0.8))
    assert white == pytest.approx(ROWS, rel=0.5)  # noise is known at one frequency less well than over all
    assert alike == pytest.approx(ROWS * 1.8 / 0.2, rel=0.5)


def test_recordings_add_up_and_one_row_tells_nothing():
    held = few_rows(np.zeros(ROWS), name="a")
    one = fisher_information(EquationErrorProblem([held]), noise(0.5), np.ones((ROWS, 1)))
    twice = fisher_information(EquationErrorProblem([held, held]), np.tile(noise(0.5), 2), np.ones((2 * ROWS, 1)))
    assert twice == pytest.approx(2.0 * one)
    single = fisher_information(EquationErrorProblem([few_rows(np.zeros(1))]), np.ones(1), np.ones((1, 1)))
    assert single == 0.0


def test_torque_and_encoders_have_each_their_own_noise():
    """Rows of the encoders that are correlated take nothing from those of the torque."""
    problem = EquationErrorProblem([few_rows(np.zeros(ROWS), encoder=np.zeros(ROWS))])
    residual = np.r_[noise(0.0), noise(0.8, seed=4)]
    slopes = np.zeros((2 * ROWS, 2))
    slopes[:ROWS, 0] = slopes[ROWS:, 1] = 1.0
    told = fisher_information(problem, residual, slopes)
    assert told[0, 0] == pytest.approx(ROWS, rel=0.2)
    assert told[1, 1] == pytest.approx(ROWS / 9.0, rel=0.3)
    assert told[0, 1] == pytest.approx(0.0, abs=1e-6 * ROWS)


def test_what_is_known_before_counts_as_well(stock):
    """Where rows say nothing of constants, these are as sure as their file has them."""
    h = null_hypothesis(stock)
    problem = EquationErrorProblem([few_rows(np.zeros(ROWS))])
    f = SimpleNamespace(hypothesis=h, residual=noise(0.0), jacobian=np.zeros((ROWS, len(h.free))))
    stated = np.array([free.prior[1] for free in h.free])
    assert np.sqrt(np.diag(cramer_rao(problem, f))) == pytest.approx(stated)

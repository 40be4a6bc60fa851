"""What a basis gains by chance: one unit a column on white noise, many times that where neighbouring rows are alike."""

from types import SimpleNamespace

import numpy as np
import pytest

from ema_twin_sim.identification.chance import gain_on_correlated_noise
from ema_twin_sim.identification.equation import EquationErrorProblem
from ema_twin_sim.identification.fit import fit
from ema_twin_sim.identification.null_hypothesis import null_hypothesis
from tests.few_rows import few_rows

ROWS, COLUMNS = 2000, 8


@pytest.fixture(scope="module")
def null(stock):
    """A fit to rows of white noise, and hats over the time as a basis."""
    noise = 0.01 * np.random.default_rng(1).standard_normal(ROWS)
    problem = EquationErrorProblem([few_rows(noise)])
    at = np.linspace(0.0, COLUMNS - 1.0, ROWS)
    hats = np.stack([np.interp(at, np.arange(COLUMNS), row) for row in np.eye(COLUMNS)], 1)
    problem = problem.with_generic_bases({"time#0": hats})
    return problem, fit(problem, null_hypothesis(stock), 0)


def left(problem, residual):
    """A fit that leaves a residual (m,) of torque, in units of noise."""
    return SimpleNamespace(residual=np.concatenate([residual, np.zeros(problem.rows - problem.size)]))


def test_on_white_noise_a_column_gains_one_unit(null):
    problem, f = null
    white = np.random.default_rng(2).standard_normal((40, ROWS)) * f.row_variance_inflations[0] ** 0.5
    gained = [gain_on_correlated_noise(problem, f, left(problem, noise), "time#0") for noise in white]
    assert np.mean(gained) == pytest.approx(COLUMNS, rel=0.2)


def test_where_neighbouring_rows_are_alike_it_gains_many_times_that(null):
    problem, f = null
    slow = np.repeat(np.random.default_rng(3).standard_normal(ROWS // 100), 100)
    slow *= f.row_variance_inflations[0] ** 0.5 / slow.std()
    assert gain_on_correlated_noise(problem, f, left(problem, slow), "time#0") > 10.0 * COLUMNS


def test_what_is_fast_gains_nothing(null):
    problem, f = null
    fast = np.sqrt(2.0) * np.cos(0.9 * np.pi * np.arange(ROWS))
    assert gain_on_correlated_noise(problem, f, left(problem, fast), "time#0") < 0.1 * COLUMNS

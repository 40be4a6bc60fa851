"""What a basis gains by chance: one unit a column on white noise, many times that where neighbouring rows are alike."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lfilter

from ema_twin_sim.identification.chance import gain_on_correlated_noise, noise_along
from ema_twin_sim.identification.equation import EquationErrorProblem
from ema_twin_sim.identification.fit import fit
from ema_twin_sim.identification.generic_bases import fit_with_basis
from ema_twin_sim.identification.null_hypothesis import null_hypothesis
from tests.few_rows import few_rows

ROWS, COLUMNS, NOISE = 2000, 8, 0.01
at = np.linspace(0.0, COLUMNS - 1.0, ROWS)
HATS = np.stack([np.interp(at, np.arange(COLUMNS), row) for row in np.eye(COLUMNS)], 1)
PLACES = np.random.default_rng(7).permutation(ROWS)


def told_and_gained(stock, noise, columns, kernel=(0.0, 1.0, 0.0)):
    """What the hats are said to gain by chance on a noise (m,) of one unit, and what they gain."""
    h = null_hypothesis(stock)
    rows = few_rows(np.zeros(ROWS), NOISE, kernel=kernel)
    torque = NOISE * (EquationErrorProblem([rows]).predict(h).rows[:ROWS] + noise)
    problem = EquationErrorProblem([dataclasses.replace(rows, torque=torque)])
    problem = problem.with_generic_bases({"time#0": columns})
    before = fit(problem, h)
    after = fit_with_basis(problem, before, "time#0")
    return gain_on_correlated_noise(problem, before, after, "time#0"), before.misfits[0] - after.misfits[0]


def alike(seed, likeness):
    """Noise (m,) of one unit, each value ``likeness`` times the one before and a new one."""
    noise = lfilter([np.sqrt(1.0 - likeness**2)], [1.0, -likeness], np.random.default_rng(seed).standard_normal(ROWS))
    return noise / noise.std()


@pytest.mark.parametrize(("likeness", "least", "most"), [(0.0, 0.7, 1.3), (0.5, 2.0, 4.0), (0.9, 12.0, 25.0)])
def test_it_is_what_the_basis_gains_the_more_the_more_rows_are_alike(likeness, least, most, stock):
    """Though the fit with the basis has taken the basis's own share out of what is left."""
    each = np.array([told_and_gained(stock, alike(seed, likeness), HATS) for seed in range(20)])
    told, gained = each.mean(axis=0)
    assert least * COLUMNS < told < most * COLUMNS
    assert told == pytest.approx(gained, rel=0.35)


def test_where_it_rises_towards_the_slowest_it_is_a_lower_bound(stock):
    """What the basis took there, nothing tells."""
    each = np.array([told_and_gained(stock, alike(seed, 0.99), HATS) for seed in range(20)])
    told, gained = each.mean(axis=0)
    assert 12.0 * COLUMNS < told < gained


def test_what_is_fast_gains_nothing(stock):
    fast = np.sqrt(2.0) * np.cos(0.9 * np.pi * np.arange(ROWS))
    assert told_and_gained(stock, fast, HATS)[0] < 0.1 * COLUMNS


@pytest.mark.parametrize("periods", [6, 8, 12, 16, 20])
def test_what_goes_to_and_fro_is_no_noise_of_slower_rows(periods, stock):
    """An unknown cause in a motion that repeats leaves a line: neighbouring frequencies are not as strong."""
    line = np.sqrt(2.0) * np.sin(2.0 * np.pi * periods * np.arange(ROWS) / ROWS)
    noise = 0.1 * np.random.default_rng(3).standard_normal(ROWS)
    told, gained = told_and_gained(stock, line + noise, HATS)
    assert told < 2.0 * gained + COLUMNS


def test_operating_points_have_no_neighbours(stock):
    """Whatever their order in the table."""
    noise = alike(1, 0.9)
    points, motion = (
        [told_and_gained(stock, noise[places], HATS[places], kernel)[0] for places in (np.arange(ROWS), PLACES)]
        for kernel in ((1.0,), (0.0, 1.0, 0.0))
    )
    assert points[0] == pytest.approx(points[1], rel=0.3)
    assert motion[0] > 3.0 * motion[1]


@pytest.mark.parametrize("likeness", [0.0, 0.9])
def test_noise_along_a_direction_is_as_large_as_it_scatters(likeness):
    """Also where the fit took all of it out of what is left, as it does if the direction is one of its own."""
    problem = EquationErrorProblem([few_rows(np.zeros(ROWS), NOISE, kernel=(0.0, 1.0, 0.0)) for _ in range(2)])
    direction = np.concatenate([np.sin(2.0 * np.pi * 3.0 * np.arange(ROWS) / ROWS), np.zeros(ROWS)])
    own = direction[:, None] / np.linalg.norm(direction)
    told, scattered = [], []
    for seed in range(100):
        noise = np.concatenate([alike(2 * seed, likeness), alike(2 * seed + 1, likeness)])
        left = SimpleNamespace(residual=noise - own @ (own.T @ noise), jacobian=own)
        told.append(noise_along(problem, left, direction) ** 2)
        scattered.append(noise @ direction)
    assert np.sqrt(np.mean(told)) == pytest.approx(np.std(scattered), rel=0.2)
    slow_over_white = np.sqrt((1.0 + likeness) / (1.0 - likeness))
    assert np.sqrt(np.mean(told)) == pytest.approx(slow_over_white * np.linalg.norm(direction), rel=0.2)

"""A fit stays within the bounds that it searches, wherever a step or a straight line leads."""

import math
from dataclasses import replace

import numpy as np
import pytest

from ema_twin_sim.fitting.free_parameters import choose_numbers
from ema_twin_sim.fitting.solver import Solution, refine
from ema_twin_sim.fitting.unseen import judge
from tests.fitted_bench import bench
from tests.problems import problem_of


class Rigid:
    """A misfit of one number, which falls as steeply as you like towards a rigid shaft."""

    variance = 1.0
    rows = 2

    def __init__(self, freedom):
        self.freedom = freedom
        self.parts = [(0, slice(0, 1)), (1, slice(1, 2))]

    def residual(self, values):
        return np.full(2, 1e6 - np.log(values[0]))

    def slopes(self, values, weights):
        return np.full((2, 1), 1.0 / values[0])

    def weights(self, residual):
        return np.ones(2)

    def cost(self, residual):
        return float(residual @ residual)


@pytest.fixture
def stiffness(stock):
    """A shaft's stiffness as the only free number, of which nothing is known."""
    model = stock.with_effect("shaft_compliance")
    freedom = choose_numbers(model, (), ())
    k = freedom.index("effects.shaft_compliance.stiffness")
    freedom = replace(freedom, numbers=(freedom.numbers[k],), start=freedom.start[[k]])
    return freedom.with_priors_loose([0])


def test_a_stiffness_that_runs_away_overflows_nothing(stiffness):
    """Its logarithm would have to rise by a million: no number is that large."""
    assert math.isinf(stiffness.numbers[0].upper)
    found = refine(Rigid(stiffness), stiffness.start, 5)
    assert np.isfinite(found.values).all() and found.values[0] > 1e3


def test_it_is_searched_as_far_as_it_can_matter(stock, stiffness):
    searched = stiffness.within(problem_of(bench(stock, ("sine:0.05:0.5",)), stock).reached).numbers[0]
    assert 100.0 * stiffness.start[0] < searched.upper < 1e6 * stiffness.start[0]
    assert searched.lower < stiffness.start[0]


def test_what_is_judged_on_unseen_data_stays_within_what_was_searched(stock, stiffness, monkeypatch):
    recordings = bench(stock, ("sine:0.05:0.5", "ramp:0.03"))
    searched = stiffness.within(problem_of(recordings, stock).reached)
    misfit = Rigid(searched)
    # each recording alone draws the stiffness to where no straight line holds
    slopes, residual = np.full((2, 1), 1e-3), np.array([1e6, -1e6])
    solution = Solution(searched, searched.start, residual, lambda: slopes, 1.0, 1.0, True)
    tried = []
    monkeypatch.setattr("ema_twin_sim.fitting.unseen.errors", lambda r, s, models, *rest: tried.append(models))
    judge(recordings, ["setpoint", "setpoint"], stock, {}, misfit, solution, {})
    values = [model.effects["shaft_compliance"].parameters["stiffness"] for model in tried[0]]
    bounds = searched.numbers[0]
    assert all(bounds.lower <= value <= bounds.upper * (1.0 + 1e-9) for value in values)
    assert max(values) == pytest.approx(bounds.upper)

"""Features judged together call off the told share of healthy runs, however few the healthy tests are."""

from dataclasses import replace

import numpy as np
import pytest

from ema_twin_sim.health.baseline import LEVELS, learn_from
from ema_twin_sim.health.between_tests import predict
from ema_twin_sim.health.block_limit import block_limit
from ema_twin_sim.health.features import Feature, Features
from tests.health_by_hand import run_by_hand

RATE = 0.01


def healthy(rng, tests, runs, between):
    """Runs (n, 4) of several tests that differ in all features alike, by ``between`` times what runs scatter."""
    shared = between * rng.normal(size=(tests, 1, 1))
    names = [str(test) for test in range(tests) for _ in range(runs)]
    return (shared + rng.normal(size=(tests, runs, 4))).reshape(-1, 4), names


def called_off(tests, units=400):
    """Share of further runs of further tests beyond the drawn limit, and beyond the rate itself.

    Units differ so much that the shares of 400 of them are known to 0.2 to 0.3 %.
    """
    rng = np.random.default_rng(100 + tests)
    drawn, told = [], []
    for _ in range(units):
        learnt = predict(*healthy(rng, tests, 5, 5.0))
        limit = block_limit(learnt, RATE)
        tails = np.array([learnt.tail(one) for one in healthy(rng, 40, 1, 5.0)[0]])
        drawn.append(np.mean(tails < limit))
        told.append(np.mean(tails < np.log(RATE)))
    return float(np.mean(drawn)), float(np.mean(told))


@pytest.mark.slow
@pytest.mark.parametrize("tests", [4, 5, 7])
def test_few_tests_that_differ_more_than_runs_call_off_the_told_share(tests):
    drawn, told = called_off(tests)
    assert drawn <= 1.5 * RATE and drawn < told


def test_the_told_share_of_left_out_runs_is_that_of_the_limits_in_use():
    """Judged by four tests and the limit drawn for five, a little more than one in a hundred is beyond it."""
    rng = np.random.default_rng(5)
    told = []
    for _ in range(40):
        values, names = healthy(rng, 5, 5, 5.0)
        runs = []
        for one, test in zip(0.01 * values, names, strict=True):
            levels = {name: Feature(value, "A", True) for name, value in zip(LEVELS, one, strict=True)}
            runs.append(replace(run_by_hand("a run", rng), test=test, features=Features(levels, (1.0, 1.0))))
        told.append(learn_from(runs).false_alarms_left_out)
    assert np.mean(told) <= 2.0 * RATE


def test_many_tests_leave_the_limit_as_told():
    learnt = predict(*healthy(np.random.default_rng(1), 200, 2, 0.5))
    assert block_limit(learnt, RATE) == pytest.approx(np.log(RATE), abs=0.25)


@pytest.mark.parametrize("rate", [1e-3, 1e-4, 1e-6])
def test_a_rare_false_alarm_is_not_called_off_more_often_than_told(rate):
    """Of a unit with many tests the rate itself is the limit; a unit with several motions divides the rate by them."""
    learnt = predict(*healthy(np.random.default_rng(1), 400, 2, 0.5))
    assert np.log(rate) - 0.5 < block_limit(learnt, rate) < np.log(rate) + 0.25


def test_the_limit_is_the_same_each_time_and_takes_many_runs():
    learnt = predict(*healthy(np.random.default_rng(2), 4, 5000, 1.0))
    assert block_limit(learnt, RATE) == block_limit(learnt, RATE)

"""How sure numbers are said to be, held against how far they really scatter."""

import numpy as np
import pytest

from ema_twin_sim.discovery.criteria.plausible import uncertain
from ema_twin_sim.identification.estimates import standard_errors
from ema_twin_sim.identification.fit import fit
from ema_twin_sim.identification.null_hypothesis import null_hypothesis
from ema_twin_sim.identification.uncertainty import covariance, disagreement
from tests.problems import problem_of
from tests.recorded import record

BLOCKS, ROWS, DRAWS = 6, 60, 2000
NO_PRIOR = np.zeros((0, 2))


def slopes_of(random, alone):
    """Slopes (m, 2) of two numbers: one that every block shows, one that the last shows ``alone`` times as well."""
    which = np.repeat(np.arange(BLOCKS), ROWS)
    slopes = random.normal(size=(BLOCKS * ROWS, 2))
    slopes[which == BLOCKS - 1, 1] *= alone
    return slopes, which


def told_over_true(random, slopes, which, noise):
    """(2,) mean variance that is told of both numbers, over the variance that they have, by many draws of noise."""
    solve = np.linalg.pinv(slopes)
    estimates, told = [], []
    for _ in range(DRAWS):
        measured = noise(random)
        estimate = solve @ measured
        estimates.append(estimate)
        told.append(np.diag(disagreement(slopes, measured - slopes @ estimate, NO_PRIOR, which)))
    return np.mean(told, axis=0) / np.var(estimates, axis=0)


@pytest.mark.slow
@pytest.mark.parametrize("alone", [1.0, 3.0, 10.0])
def test_white_noise_is_told_as_large_as_it_is_however_little_other_recordings_show(alone):
    random = np.random.default_rng(4)
    slopes, which = slopes_of(random, alone)
    ratio = told_over_true(random, slopes, which, lambda random: random.normal(size=len(which)))
    assert ratio == pytest.approx(1.0, abs=0.15)


def test_what_all_rows_of_a_recording_have_in_common_is_told_too():
    """White least squares would tell a tenth of that."""
    random = np.random.default_rng(5)
    which = np.repeat(np.arange(BLOCKS), ROWS)
    slopes = np.stack([np.ones(len(which)), random.normal(size=len(which))], 1)
    ratio = told_over_true(
        random, slopes, which, lambda random: random.normal(size=BLOCKS)[which] + 0.1 * random.normal(size=len(which))
    )
    assert 0.7 < ratio[0] < 1.3


def test_beside_what_is_held_the_rest_is_as_sure_as_without_it(stock):
    """In one direction a load and friction that differs by direction are alike: known, that friction is no excuse."""
    problem = problem_of(record(stock, ("ramp:0.05", "ramp:0.2"), 4.0), stock)
    load = null_hypothesis(stock).with_effect("constant_load", {}, {"torque": 0.0})
    beside = load.with_effect("asymmetric_friction", {}, {"fraction": 0.0})
    either, held, alone = (
        standard_errors(problem, fit(problem, h, 0))
        for h in (beside, beside.holding({"effects.asymmetric_friction.fraction": 0.0}), load)
    )
    assert held == pytest.approx(alone, rel=1e-6)
    assert either["effects.constant_load.torque"] > 1.3 * alone["effects.constant_load.torque"]


def test_a_wave_of_the_torque_is_as_sure_however_badly_the_encoders_are_explained(stock):
    true = stock.with_effect("backlash", {"width": 2e-3}).with_effect("cogging", {"torque": 0.1})
    problem = problem_of(record(true, ("sine:0.3:0.5", "ramp:0.1"), 4.0), stock)
    found = null_hypothesis(stock).with_effect("backlash", {}, {"width": 2e-3})
    found = found.with_effect("cogging", {}, {"torque": 0.1})
    wrong = found.put({**found.by_path, "effects.backlash.width": 5e-3})
    wave = [free.path for free in found.free].index("effects.cogging.torque")
    errors = {}
    for name, h in (("right", found), ("wrong", wrong)):
        f = fit(problem, h, 0)
        errors[name] = [np.sqrt(np.diag(covariance(problem, f, by_torque=by_torque))) for by_torque in (False, True)]
    assert "cogging" not in [*uncertain(problem, f)]
    assert errors["wrong"][0][wave] > 3.0 * errors["right"][0][wave]
    assert errors["wrong"][1][wave] < 2.0 * errors["right"][1][wave]

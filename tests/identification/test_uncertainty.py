"""How sure numbers are said to be, held against how far they really scatter."""

import numpy as np
import pytest

from ema_twin_sim.identification.uncertainty import disagreement

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

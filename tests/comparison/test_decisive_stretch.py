"""A few samples that decide an RMSE are told with where they are, and with what leaves them out."""

import re
from types import SimpleNamespace

import numpy as np
import pytest

from ema_twin_sim.comparison.decisive_stretch import decisive_stretch
from ema_twin_sim.words.decisive import decisive_sentence
from tests.command_line import MODEL, done

TIME = np.arange(10_000) * 2e-3


def noisy(first=0, last=0, size=0.0):
    """A residual of noise, with an error of that size at the samples between two others."""
    residual = np.random.default_rng(1).normal(size=len(TIME))
    residual[first:last] += size
    return residual


@pytest.mark.parametrize("first", [0, 5000, 9900])
def test_one_short_event_decides(first):
    found = decisive_stretch(noisy(first, first + 100, 30.0), TIME)
    assert (found.begin, found.end) == pytest.approx((TIME[first], TIME[first] + 0.2), abs=0.1)
    assert 0.005 <= found.of_samples <= 0.01 and 0.75 <= found.of_squares <= 1.0


def test_what_lasts_repeats_or_is_no_larger_than_the_rest_does_not():
    twice = noisy(0, 100, 30.0) + noisy(7000, 7100, 30.0)
    for residual in (noisy(), noisy(0, 2000, 30.0), noisy(0, 100, 3.0), twice, np.zeros_like(TIME)):
        assert decisive_stretch(residual, TIME) is None


def test_samples_without_a_value_do_not_count_and_few_samples_tell_nothing():
    residual = noisy(0, 100, 30.0)
    residual[5000:5010] = np.nan
    assert decisive_stretch(residual, TIME) is not None
    assert decisive_stretch(residual[:150], TIME[:150]) is None


def told(*residuals, start=0.0):
    """The sentence on recordings with these errors of the current."""
    recordings, floor = [], 0.1
    for k, residual in enumerate(residuals):
        found = decisive_stretch(residual, TIME)
        recordings.append(
            SimpleNamespace(
                name=f"run {k}",
                samples=len(TIME),
                duration=float(TIME[-1]),
                signals={"current": {"rmse": float(np.sqrt(np.mean(residual**2)))}},
                stretches={} if found is None else {"current": found},
            )
        )
    overall = {"current": {"rmse": 10.0 * floor, "noise_floor": floor, "driven": False, "unit": "A"}}
    return decisive_sentence(SimpleNamespace(input="setpoint", overall=overall, recordings=recordings), start)


def test_it_is_told_with_the_option_that_leaves_it_out():
    first = told(noisy(0, 100, 30.0), start=1.5)
    assert first.startswith("run 0: 1.5 to 1.7 s (1 % of its samples) hold 9") and "(--from 1.7)" in first
    assert told(noisy(9900, 10_000, 30.0)).endswith("--to 19.8")
    assert told(noisy(5000, 5100, 30.0)).endswith("--to for what is before it, --from for what is after it")
    later = told(noisy(0, 100, 30.0), noisy(0, 200, 40.0))
    assert later.startswith("run 1: 0 to 0.4 s") and "(likewise in 1 more)" in later and "(--from 0.4)" in later


def test_what_decides_one_recording_but_not_all_of_them_is_not_told():
    assert told(noisy(0, 100, 30.0), 30.0 * noisy()) == ""
    assert told(noisy()) == ""


def test_compare_notes_the_start_of_a_ramp_and_not_its_steady_rest(ramp):
    note = r"Note: BancoEMA_ramp_0.05: 0 to 0.1 s \(0.5 % of its samples\) hold 7\d % of the squared error of the speed"
    assert re.search(note, done("compare", ramp, *MODEL).stdout)
    assert "Note: " not in done("compare", ramp, *MODEL, "--from", "1").stdout

"""An encoder error that is a straight line over the way of the recordings is told with the gear ratio that would do."""

import re

import pytest

from ema_twin_sim.discovery.straight_waves import of_straight_waves
from ema_twin_sim.identification.fit import fit
from ema_twin_sim.identification.null_hypothesis import null_hypothesis
from tests.problems import problem_of
from tests.recorded import record, scaled

WIDE = ("triangle:3.5:12", "sine:3.0:0.1")  # rad, a turn of the output and more


def fitted_wave(recordings, stock, orders=("1",), phase=0.5):
    """The model with waves of the encoder, fitted to the encoders of recordings."""
    problem = problem_of(recordings, stock)
    h = null_hypothesis(stock)
    for order in orders:
        h = h.with_effect("encoder_eccentricity", {"order": order}, {"amplitude": 1e-3, "phase": phase})
    return problem, fit(problem, h, 20)


@pytest.fixture(scope="module")
def narrow(stock):
    return record(stock, ("triangle:0.2:4", "sine:0.15:0.2"), 10.0)


@pytest.mark.parametrize("factor", [1.004, 0.99])
def test_a_wave_that_is_a_line_is_told_with_the_gear_ratio_that_would_do(factor, narrow, stock):
    runs = [scaled(recording, output_position=factor) for recording in narrow]
    (said,) = of_straight_waves(*fitted_wave(runs, stock, phase=0.5 if factor > 1.0 else 3.6))
    ratio = float(re.search(r"a gear ratio of ([\d.]+) instead of 124 ", said)[1])
    assert ratio == pytest.approx(124.0 / factor, rel=1e-4)
    assert f"{100.0 * abs(factor - 1.0):.1g} %" in said


def test_a_wave_of_which_a_turn_is_seen_is_a_wave(stock):
    eccentric = stock.with_effect("encoder_eccentricity", {"amplitude": 1e-3, "phase": 0.4}, {"order": "1"})
    problem, found = fitted_wave(record(eccentric, WIDE, 12.0), stock)
    assert found.hypothesis.by_path["effects.encoder_eccentricity.amplitude"] == pytest.approx(1e-3, rel=0.05)
    assert of_straight_waves(problem, found) == ()


def test_without_a_wave_there_is_nothing_to_say(narrow, stock):
    assert of_straight_waves(*fitted_wave(narrow, stock, ())) == ()

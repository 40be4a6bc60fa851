"""The wave that repeats with the position: from strokes that hold it, each by what it tells, and in words."""

import numpy as np
import pytest

from ema_twin_sim.health import MotionRecord
from ema_twin_sim.health.features import features_of
from ema_twin_sim.health.run_features import run_features
from ema_twin_sim.health.wave import wave_phasor
from ema_twin_sim.quantities import quantity

TURN = 2.0 * np.pi


def run(travel, seed=1, wave=0.1):
    """Out, rest, back over a travel [rad]; a wave a turn, and the current's noise."""
    time = np.arange(0.0, 9.0, 0.01)
    place = np.interp(time, [0.0, 3.0, 5.0, 8.0, 9.0], [0.0, travel, travel, 0.0, 0.0])
    way = np.sign(np.gradient(place))
    effort = way * (1.0 + wave * np.cos(place)) + 0.02 * np.random.default_rng(seed).normal(size=len(time))
    return MotionRecord("run", "test", time, place, effort, position_unit="rad")


@pytest.mark.parametrize("turns", [0.02, 0.1, 0.5, 1.0])
def test_a_stroke_that_holds_no_wave_has_no_feature_of_it(turns):
    found = features_of(run(turns * TURN), TURN, False).values
    assert not [name for name in found if "wave" in name]


@pytest.mark.parametrize("turns", [3.0, 20.0])
def test_a_wave_is_told_in_percent_of_the_effort(turns):
    found = features_of(run(turns * TURN), TURN, False).values
    assert found["wave_depth"].value == pytest.approx(10.0, abs=1.0) and found["wave_depth"].unit == "%"
    assert not found["wave_depth"].scales
    assert quantity(0.35, "%") == "0.35 %" and quantity(0.0042, "1") == "0.0042"
    assert quantity(-8.88e-19, "N m") == "-8.88e-19 N m" and quantity(5e-11, "A") == "0.0500 nA"


def test_that_the_strokes_are_too_short_for_the_wave_is_said_with_their_length():
    (said,) = run_features(run(0.1 * TURN), TURN).acquisition.findings
    assert "the longest stroke is 0.075 times its wavelength of 6.28 rad" in said
    assert run_features(run(20.0 * TURN), TURN).acquisition.findings == ()


def test_a_short_stroke_beside_long_ones_does_not_decide_their_wave():
    rng = np.random.default_rng(2)

    def stroke(turns, samples):
        place = np.linspace(0.0, turns * TURN, samples)
        return np.cos(place) + 0.1 * rng.normal(size=samples), place

    long = [stroke(10.0, 1000) for _ in range(2)]
    alone, beside = wave_phasor(long, TURN), wave_phasor([*long, stroke(0.1, 20), stroke(0.6, 60)], TURN)
    assert alone == pytest.approx(1.0, abs=0.02) and beside == pytest.approx(alone, abs=0.02)

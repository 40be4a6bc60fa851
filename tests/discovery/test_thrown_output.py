"""An output that is thrown through wide play: what its encoder shows is no lost count, and the play is named."""

from dataclasses import replace

import numpy as np
import pytest

from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.identification.equation import EquationErrorProblem
from ema_twin_sim.identification.excerpt import excerpt
from ema_twin_sim.identification.null_hypothesis import null_hypothesis
from ema_twin_sim.measured.observe import observe_all
from ema_twin_sim.measured.spoilt_samples import counter_jumps
from ema_twin_sim.plant.measured_motion import REQUIRED
from ema_twin_sim.plant.motion import MOTOR_ANGLE, OUTPUT_ANGLE, SPEED
from ema_twin_sim.simulation.driving_flank import lead
from tests.problems import problem_of
from tests.recorded import record

FAST = ("triangle:0.4839:2",)
"""Up to 60 rad/s of the motor, one reversal a second."""


@pytest.fixture(scope="module")
def thrown(stock):
    """One recording of a bench whose play of 10 mrad throws its output for a good part of each way."""
    return record(stock.with_effect("backlash", {"width": 0.01}), FAST)


def test_an_output_that_comes_back_from_its_teeth_is_no_lost_count():
    """It crosses the gap at 3 rad/s and comes back at 2, of a motor that stands; a count that is lost stands alone."""
    period, noise = 0.002, 1e-6
    flight = np.concatenate([np.arange(0.0, 0.02, 3.0 * period), 0.02 - np.arange(0.0, 0.015, 2.0 * period)])
    difference = np.r_[np.zeros(50), flight, np.full(50, flight[-1])]
    difference += noise * np.random.default_rng(1).normal(size=len(difference))
    still = np.zeros(len(difference))
    assert not counter_jumps(difference, still, 0.0).any()
    difference[-20:] += 1e-4
    assert np.flatnonzero(counter_jumps(difference, still, 0.0)).tolist() == [len(difference) - 20]
    difference[-10:] += 1e-4
    difference[-9:] += 1e-4  # counts that are lost over two samples are lost too
    assert np.flatnonzero(counter_jumps(difference, still, 0.0)).tolist() == [len(difference) - k for k in (20, 10, 9)]


def test_an_excerpt_holds_a_reversal_that_the_encoders_show_from_both_sides(thrown, stock):
    part = excerpt(problem_of(thrown, stock))
    (o,) = part.observations
    assert {*np.sign(o.motion[o.encoder_rows, SPEED])} == {-1.0, 1.0}


def test_what_begins_in_motion_begins_where_its_encoder_shows_it(thrown, stock):
    """The whole recording begins in the middle of the gap: since then the encoders tell how far the motor is ahead."""
    (whole,) = observe_all(thrown, stock)
    ratio = stock.value("machine.gear_ratio")
    first = int(np.argmax(whole.motion[:, SPEED] > 30.0))
    _, part = _begun_at(first, whole, stock)
    shown = whole.motion[first, MOTOR_ANGLE] - whole.motion[first, OUTPUT_ANGLE] * ratio
    assert part == pytest.approx(shown, abs=0.01 * 0.005 * ratio)  # a hundredth of half the play


def test_what_begins_in_motion_unseen_begins_on_the_driving_flank(thrown, stock):
    """As in the simulation: a rigid prediction lies off by half the play and what friction presses the teeth."""
    (recording,) = thrown
    signals = {name: values for name, values in recording.signals.items() if name != "output_position"}
    (whole,) = observe_all([replace(recording, signals=signals)], stock)
    first = int(np.argmax(whole.motion[:, SPEED] > 30.0))
    plant, part = _begun_at(first, whole, stock)
    assert part == pytest.approx(lead(plant, whole.motion[first, SPEED]), rel=1e-3)


def test_until_its_teeth_meet_an_output_is_where_it_was_seen(thrown, stock):
    """It flies at first, half a gap away from either side, and nobody knows that but its encoder."""
    (whole,) = observe_all(thrown, stock)
    behind = whole.motion[:, MOTOR_ANGLE] - whole.motion[:, OUTPUT_ANGLE] * stock.value("machine.gear_ratio")
    half = 0.005 * stock.value("machine.gear_ratio")
    free = np.flatnonzero((np.abs(behind) < 0.5 * half) & (np.arange(len(behind)) > 300))
    problem = EquationErrorProblem([whole.window(int(free[0]), len(whole.motion))])
    predicted = problem.predict(null_hypothesis(stock).with_effect("backlash", {}, {"width": 0.01}))
    (required,) = predicted.required_by_recording
    meets = int(np.argmax(required[:, REQUIRED.index("transmitted")] != 0.0))
    (o,) = problem.observations
    shown = (o.motion[:meets, OUTPUT_ANGLE] - required[:meets, REQUIRED.index("output")]) / half
    assert meets > 10
    assert np.ptp(shown) * stock.value("machine.gear_ratio") < 1e-3  # of half the gap, through which it flies


def _begun_at(first, whole, stock):
    """The plant, and by how much [rad] a motor is ahead of the output, of an observation from a sample on."""
    problem = EquationErrorProblem([whole.window(first, len(whole.motion))])
    h = null_hypothesis(stock).with_effect("backlash", {}, {"width": 0.01})
    predicted = problem.predict(h)
    start = problem.observations[0].motion[0]
    behind = start[MOTOR_ANGLE] - predicted.required_by_recording[0][0, 1] * stock.value("machine.gear_ratio")
    return predicted.plant[0], behind


@pytest.mark.slow
@pytest.mark.parametrize(
    ("width", "run"),
    [(0.01, ("triangle:0.2:2",)), (0.01, ("triangle:0.4:2",)), (0.02, ("triangle:0.2:3",))],
)
def test_wide_play_is_all_that_is_missing(width, run, stock):
    found = discover(record(stock.with_effect("backlash", {"width": width}), run), stock)
    assert (found.verdict, found.added) == ("explained", ("backlash",))
    assert found.parameters["backlash"]["width"]["value"] == pytest.approx(width, rel=0.01)


@pytest.mark.slow
def test_play_that_throws_its_output_is_named_and_sized(thrown, stock):
    """What is left of such impacts goes with the last digit of what is measured: the verdict is either."""
    found = discover(thrown, stock)
    assert found.added == ("backlash",)
    assert found.parameters["backlash"]["width"]["value"] == pytest.approx(0.01, rel=0.01)

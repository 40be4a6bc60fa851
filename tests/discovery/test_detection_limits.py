"""Detection limits (make accuracy ARGS=--limits): the smallest size that rows tell, and what hides it."""

import math

import numpy as np
import pytest

from ema_twin_sim.criteria import LEAST_SIZE
from ema_twin_sim.discovery.criteria.own_shape import by_own_shape
from ema_twin_sim.discovery.criteria.worth import has_effect_size, largest_rms_reduction, penalised_gain
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.discovery.search.adding import settle
from ema_twin_sim.identification.cramer_rao import whitened
from ema_twin_sim.identification.fit import fit
from tests.accuracy.folders import readable_train
from tests.accuracy.limits import limit_of, limited_bench
from tests.problems import fit_of, problem_of
from tests.recorded import COMMANDS, lined, record


def test_a_wave_is_told_by_the_noise_at_its_own_frequency():
    """Information of a wave in an AR(1) noise, from that noise's spectrum; rows that are missing tell nothing."""
    random = np.random.default_rng(2)
    noise = np.zeros(2000)
    for k in range(1, 2000):
        noise[k] = 0.6 * noise[k - 1] + random.normal()
    at = np.delete(np.arange(2000), slice(700, 800))
    for frequency in (0.2, 2.0):
        wave = np.cos(frequency * at)[:, None]
        density = 1.0 / abs(1.0 - 0.6 * np.exp(-1j * frequency)) ** 2
        information = float(np.sum(whitened(at, noise[at], wave) ** 2))
        assert information == pytest.approx(0.5 * len(at) / density, rel=0.3)


def test_what_leaves_nothing_is_told_for_sure_and_a_long_recording_in_little_memory():
    """A band of the covariance is kept, not the whole: of 15,000 rows that would be 1.8 GB.

    White noise leaves a slope what least squares leave it.
    """
    slopes = np.random.default_rng(3).normal(size=(15_000, 1))
    exact = whitened(np.arange(15_000), np.zeros(15_000), slopes)
    assert np.isfinite(exact).all() and float(np.sum(exact**2)) > 1e12
    noise = np.random.default_rng(4).normal(0.0, 0.5, 15_000)
    white = whitened(np.arange(15_000) * 5, noise, slopes)
    assert float(np.sum(white**2)) == pytest.approx(float(np.sum(slopes**2)) / 0.25, rel=0.15)


def test_lines_that_an_encoder_interpolates_wrongly_do_not_hide_a_torque(stock):
    """How far the encoders part says nothing of how well the torque is known."""
    recordings = record(stock.with_effect("cogging", {"torque": 0.003, "phase": 0.3}))
    gains = []
    for shown in (recordings, lined(recordings, 3e-5)):
        bare = settle(fit_of(shown, stock))
        with_cogging = bare.hypothesis.with_effect("cogging", {"order": "24"}, {"torque": 0.002, "phase": 0.3})
        gains.append(penalised_gain(bare, fit(bare.problem, with_cogging)))
    assert gains[1] == pytest.approx(gains[0], rel=0.02)


def delay_stands(recordings, stock):
    """Whether an encoder's delay stands that is fitted to recordings as if nothing gave way."""
    f = settle(fit_of(recordings, stock, encoder_delay={"delay": 1e-5}))
    return by_own_shape(f.problem, f) == ("encoder_delay",)


def test_a_small_delay_stands_beside_what_the_encoder_errs_by_between_its_lines(stock):
    assert delay_stands(lined(record(stock.with_effect("encoder_delay", {"delay": 2e-4})), 1e-5), stock)


def test_a_shaft_that_winds_up_is_no_delay(stock):
    wound_up = record(stock.with_effect("shaft_compliance", {"stiffness": 400.0, "damping": 0.1}))
    assert not delay_stands(lined(wound_up, 1e-5), stock)


@pytest.mark.slow
def test_cogging_of_three_times_the_limit_is_named_on_an_unkind_bench():
    """Its gearbox rings, so that play comes in by the encoders, makes cogging needless, and goes again."""
    case = limit_of(limited_bench("cogging", 1, 1)).hidden_at(3.0)
    assert discover(readable_train(case), case.start_model).added == ("cogging",)


@pytest.mark.parametrize(
    ("effect", "angle", "options", "named"),
    [("cogging", "phase", {"order": "24"}, True), ("gravity_load", "angle", {}, False)],
)
def test_a_wave_over_the_motors_angle_is_named_below_the_size_that_others_need(effect, angle, options, named, stock):
    """Nothing else that a model gets slightly wrong repeats with each turn of the motor."""
    noise = float(np.median(problem_of(record(stock), stock).noise))
    hidden = {"torque": 0.17 * math.sqrt(2.0) * noise, angle: 0.3}
    bare = settle(fit_of(record(stock.with_effect(effect, hidden)), stock))
    after = fit(bare.problem, bare.hypothesis.with_effect(effect, options, hidden))
    assert largest_rms_reduction(bare.problem, bare, after) < LEAST_SIZE
    assert has_effect_size(bare.problem, bare, after) == named


@pytest.mark.slow
def test_the_order_that_noise_shows_most_is_one_of_many(stock):
    """Beside something unknown, a wave at the order that is left the most gains more than the true one by chance."""
    case = limit_of(limited_bench("cogging", 1, 3)).hidden_at(3.0)
    rigid = ("backlash", "shaft_compliance")  # this gearbox rings, and beside a spring so small a wave is not named
    assert discover(readable_train(case), case.start_model, without=rigid).added == ("cogging",)


def test_a_delay_stands_out_of_lines_that_part_the_encoders_more_than_it_does(stock):
    runs = (*COMMANDS, "ramp:0.08", "triangle:0.08:2", "sine:0.07:0.4")
    late = lined(record(stock.with_effect("encoder_delay", {"delay": 6e-5}), runs, 10.0), 2e-5)
    assert delay_has_size(late, stock)


def test_lines_alone_are_no_delay(stock):
    assert not delay_has_size(lined(record(stock), 2e-5), stock)


def delay_has_size(recordings, stock):
    """Whether an encoder's delay is large enough to be named that takes hardly any of what the encoders part by."""
    bare = settle(fit_of(recordings, stock))
    after = fit(bare.problem, bare.hypothesis.with_effect("encoder_delay", {}, {"delay": 1e-5}))
    part = slice(bare.problem.size, bare.problem.rows)
    assert np.sum(after.raw[part] ** 2) > 0.9 * np.sum(bare.raw[part] ** 2)
    return has_effect_size(bare.problem, bare, after)

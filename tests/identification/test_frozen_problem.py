"""A problem is frozen, a fit holds the one that it was fitted to, and misfits under two weightings do not compare."""

import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest

from ema_twin_sim.criteria import FAR_OFF_ROW
from ema_twin_sim.discovery.criteria.worth import (
    has_effect_size,
    largest_rms_reduction,
    noise_per_unit,
    penalised_gain,
)
from ema_twin_sim.discovery.search.adding import settle
from ema_twin_sim.identification.comparable import DifferentWeightings, as_compares, cheapest, costs_no_more
from ema_twin_sim.identification.equation import EquationErrorProblem
from ema_twin_sim.identification.fit import fit
from ema_twin_sim.identification.generic_bases import beside_generic_bases
from ema_twin_sim.identification.null_hypothesis import null_hypothesis
from ema_twin_sim.identification.wander import Wander
from ema_twin_sim.identification.weighting import FAR, Weighting
from ema_twin_sim.model.model import EffectInstance
from tests.few_rows import few_rows

NOISE = 0.01  # N m
LOAD = 0.06  # N m, constant, that the stock model lacks


@pytest.fixture(scope="module")
def problem(stock):
    """Forty rows of torque that the stock model would have, a load, noise and one outlier; twenty of the encoders."""
    random = np.random.default_rng(4)
    bare = EquationErrorProblem([few_rows(np.zeros(40))])
    torque = bare.predict(null_hypothesis(stock)).rows * NOISE + LOAD + NOISE * random.normal(size=40)
    torque[7] += 0.5
    return EquationErrorProblem([few_rows(torque, NOISE, 1e-5 * random.normal(size=20))])


@pytest.fixture(scope="module")
def bare(problem, stock):
    return fit(problem, null_hypothesis(stock))


@pytest.fixture(scope="module")
def loaded(problem, stock):
    return fit(problem, null_hypothesis(stock).with_effect("constant_load", {}, {"torque": 0.01}))


@pytest.fixture(scope="module")
def elsewhere(loaded):
    """The fit with the load under another weighting."""
    problem = loaded.problem.under(loaded.problem.weighting.from_outliers(FAR_OFF_ROW))
    return fit(problem, loaded.hypothesis)


@pytest.fixture
def wander(problem):
    directions, _ = np.linalg.qr(np.random.default_rng(2).normal(size=(problem.size, 2)))
    return Wander(0.1, ((slice(0, problem.size), directions, np.array([9.0, 4.0])),), 99.0)


class TestFrozen:
    @pytest.mark.parametrize("field", ["weighting", "use_encoder", "generic_bases", "measured", "torque"])
    def test_nothing_of_it_can_be_set(self, problem, field):
        with pytest.raises(FrozenInstanceError):
            setattr(problem, field, None)

    def test_another_weighting_leaves_it_as_it_was(self, problem, wander):
        before = dict(vars(problem))
        other = problem.under(replace(problem.weighting.from_outliers(3.0), variance_inflation=2.0, wander=wander))
        assert {name: vars(problem)[name] is value for name, value in before.items()} == dict.fromkeys(before, True)
        assert problem.weighting.cauchy_scale[0] == FAR and other.weighting.cauchy_scale[0] == 3.0
        assert problem.observations is other.observations and problem.torque is other.torque
        assert np.allclose(wander.as_measured(other.measured), problem.measured)
        assert not np.allclose(other.measured, problem.measured)
        assert np.array_equal(other.under(problem.weighting).measured, problem.measured)

    def test_the_encoders_count_in_one_and_not_in_the_other(self, problem, bare):
        alone = problem.by_torque_alone()
        assert (problem.use_encoder, problem.judged) == (True, 60)
        assert (alone.use_encoder, alone.judged) == (False, 40)
        assert not alone.residual(bare.predicted)[40:].any()
        assert problem.residual(bare.predicted)[40:].any()
        assert alone.with_encoders().compares_with(problem)

    def test_generic_bases_are_those_of_one_alone(self, problem, bare, wander):
        more = problem.with_generic_bases({"time#0": np.ones((problem.rows, 1))})
        assert not problem.generic_bases and [*more.generic_bases] == ["time#0"]
        assert more.compares_with(problem)
        assert [*more.under(problem.weighting.from_outliers(3.0)).generic_bases] == ["time#0"]
        assert not more.under(replace(problem.weighting, wander=wander)).generic_bases  # they are in units of the noise
        assert beside_generic_bases(more, bare) is more
        assert "speed" in beside_generic_bases(problem, bare).generic_bases and not problem.generic_bases

    def test_bases_of_one_noise_are_not_those_of_another(self, problem, bare, wander):
        wandering = problem.under(replace(problem.weighting, wander=wander))
        plain = beside_generic_bases(problem, bare).generic_bases
        beside = beside_generic_bases(wandering, bare).generic_bases
        assert np.allclose(wander.whitened(plain["speed"]), beside["speed"])
        assert not np.allclose(plain["speed"], beside["speed"])
        assert np.array_equal(beside_generic_bases(problem, bare).generic_bases["speed"], plain["speed"])

    def test_a_fit_settles_under_a_weighting_of_its_own(self, problem, loaded):
        settled = settle(loaded)
        assert loaded.problem is problem
        assert settled.problem.weighting.cauchy_scale[0] < FAR
        assert settled.problem.weights(settled.raw)[7] < 0.1 < 0.5 < np.median(settled.problem.weights(settled.raw))
        torque = settled.hypothesis.instance("constant_load").parameters["torque"]
        assert torque == pytest.approx(LOAD, abs=4.0 * NOISE / np.sqrt(40))
        assert settle(settled) is settled

    def test_slopes_asked_for_later_are_those_of_the_fit(self, problem, stock, wander):
        """They are found when first asked for, whatever weighting others have been fitted under since."""
        beside = problem.under(replace(problem.weighting, wander=wander))
        later, at_once = (fit(beside, null_hypothesis(stock), 0) for _ in range(2))
        expected = at_once.jacobian
        beside.under(problem.weighting)
        assert np.array_equal(later.jacobian, expected)
        plain = fit(problem, null_hypothesis(stock), 0)
        assert np.allclose(wander.whitened(plain.jacobian), expected)


class TestComparing:
    def test_fits_under_one_weighting_compare(self, problem, bare, loaded):
        assert penalised_gain(bare, loaded) > 0.0
        assert largest_rms_reduction(problem, bare, loaded) > 1.0
        assert has_effect_size(problem, bare, loaded)
        assert cheapest((bare, loaded, bare)) is loaded
        assert costs_no_more(loaded, bare) and not costs_no_more(bare, loaded)

    @pytest.mark.parametrize("compare", [penalised_gain, noise_per_unit])
    def test_fits_under_two_weightings_are_refused(self, compare, bare, elsewhere):
        with pytest.raises(DifferentWeightings, match="no effect and with constant_load"):
            compare(bare, elsewhere)

    @pytest.mark.parametrize("compare", [largest_rms_reduction, has_effect_size])
    def test_nor_are_their_rows_compared(self, compare, problem, bare, elsewhere):
        with pytest.raises(DifferentWeightings, match="no effect and with constant_load"):
            compare(problem, bare, elsewhere)

    def test_nor_is_one_of_them_the_cheapest(self, bare, elsewhere):
        with pytest.raises(DifferentWeightings):
            cheapest((bare, elsewhere))
        with pytest.raises(DifferentWeightings):
            costs_no_more(elsewhere, bare)

    def test_what_counts_no_encoders_does_not_compare_with_what_does(self, problem, bare, loaded):
        with pytest.raises(DifferentWeightings):
            penalised_gain(bare, fit(problem.by_torque_alone(), loaded.hypothesis))

    def test_nor_do_fits_to_other_recordings(self, problem, bare, loaded):
        other = EquationErrorProblem([o.without_encoders() for o in problem.observations])
        with pytest.raises(DifferentWeightings):
            penalised_gain(bare, fit(other, loaded.hypothesis))

    def test_made_again_under_one_they_do(self, problem, bare, elsewhere, loaded):
        again = as_compares(elsewhere, problem)
        assert penalised_gain(bare, again) == pytest.approx(penalised_gain(bare, loaded), rel=1e-3)
        assert as_compares(loaded, problem) is loaded

    def test_two_weightings_that_say_the_same_are_one(self, problem):
        one, other = (problem.under(problem.weighting.from_outliers(3.0)) for _ in range(2))
        assert one.weighting is not other.weighting and one.compares_with(other)
        assert not one.compares_with(problem.under(replace(one.weighting, variance_inflation=2.0)))


class TestReweighing:
    def test_outliers_begin_where_the_bulk_ends(self, problem):
        residual = np.tile([-3.0, 3.0], 30)
        scale = problem.reweighed(residual).cauchy_scale
        assert scale == pytest.approx(np.full(60, problem.outlier * 1.4826 * 3.0))
        assert problem.reweighed(residual, most=5.0).cauchy_scale == pytest.approx(np.full(60, 5.0))

    def test_what_is_no_other_by_much_is_itself(self, problem):
        residual = np.tile([-3.0, 3.0], 30)
        there = problem.under(problem.reweighed(residual))
        assert there.reweighed(1.01 * residual) is there.weighting
        even = Weighting.even(60, FAR)
        assert even.inflated(1.1) is even
        assert even.inflated(1.5).variance_inflation == 1.5


def test_rows_are_kept_by_several_threads_at_once(problem, bare):
    """A search screens effects side by side, and each thread keeps rows while others count what is kept."""
    loads = [EffectInstance("constant_load", {}, {"torque": torque}) for torque in np.linspace(0.01, 0.9, 400)]
    problem = EquationErrorProblem(problem.observations)
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(4) as threads:
            rows = list(threads.map(lambda load: problem.alike_beside_any(bare.predicted, [load]), loads))
    finally:
        sys.setswitchinterval(interval)
    alone = [problem.alike_beside_any(bare.predicted, [load]) for load in loads]
    assert len(problem.kept_rows) == len(loads)
    assert all(np.array_equal(one, other) for one, other in zip(rows, alone, strict=True))

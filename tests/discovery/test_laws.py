"""Stribeck friction ends under that law that explains most, is never there twice, nor in place of dry friction."""

import pytest

from ema_twin_sim.discovery.criteria.worth import standing_on
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.discovery.search.adding import settle, take_best, trial_of
from ema_twin_sim.discovery.search.laws import under_best_laws
from ema_twin_sim.discovery.search.removing import significant
from ema_twin_sim.discovery.search.trace import Round, Search
from ema_twin_sim.effects import kind_of
from ema_twin_sim.identification.candidates import candidates
from ema_twin_sim.identification.fit import fit
from ema_twin_sim.identification.null_hypothesis import null_hypothesis
from tests.problems import problem_of
from tests.recorded import record

STRIBECK = {"torque": 0.06, "speed": 2.0}
RUNS = ("ramp:0.05", "triangle:0.06:2", "sine:0.05:0.4", "triangle:0.01:2")
START = {"torque": 0.03, "speed": 1.0}
LAWS = ("exponential", "gaussian", "lorentzian")


def found_under(law, true_law, model):
    """A search that ended with Stribeck friction under one law, on recordings of another."""
    recordings = record(model.with_effect("stribeck_friction", STRIBECK, {"law": true_law}), RUNS, 10.0)
    null = null_hypothesis(model)
    after = settle(fit(problem_of(recordings, model), null.with_effect("stribeck_friction", {"law": law}, START), 20))
    bare = fit(after.problem, null)
    return Search(after, (Round(bare, (trial_of(bare, after),), after, ("stribeck_friction",)),))


@pytest.mark.parametrize("true_law", LAWS)
@pytest.mark.parametrize("law", LAWS)
def test_the_true_law_is_taken_with_its_numbers(law, true_law, stock):
    found = found_under(law, true_law, stock)
    ended = under_best_laws(found)
    instance = ended.fit.hypothesis.instance(*ended.fit.hypothesis.added)
    assert instance.options == {"law": true_law}
    assert instance.parameters == pytest.approx(STRIBECK, rel=0.05)
    assert ended.changes[-1].after is ended.fit and len(ended.rounds) == len(found.rounds)
    assert (ended is found) == (law == true_law)


def test_a_round_ends_under_the_true_law_so_that_no_effect_is_taken_for_the_rest(stock):
    found = found_under("gaussian", "exponential", stock)
    turn = take_best(found.rounds[0].before, [found.fit])
    (name,) = turn.added
    assert turn.after.hypothesis.added[name].options == {"law": "exponential"}
    assert turn.after.misfit < found.fit.misfit


def test_no_second_law_is_offered_beside_the_first(stock):
    h = null_hypothesis(stock)
    assert sum(c.effect == "stribeck_friction" for c in candidates(h)) == len(LAWS)
    beside = h.with_effect("stribeck_friction", {"law": "gaussian"}, STRIBECK)
    assert "stribeck_friction" not in {c.effect for c in candidates(beside)}


def test_the_law_that_a_model_declares_is_the_only_one_offered(stock):
    h = null_hypothesis(stock.with_effect("stribeck_friction", STRIBECK, {"law": "gaussian"}))
    assert [c.options["law"] for c in candidates(h) if c.effect == "stribeck_friction"] == ["gaussian"]


def test_the_law_does_not_tell_one_cause_from_another():
    """Applied to a running twin under one law, and found under the other: it is not missing again."""
    kinds = {kind_of("stribeck_friction", {"law": law}) for law in LAWS}
    assert kinds == {("stribeck_friction", ())}
    assert kind_of("cogging", {"order": "12"}) != kind_of("cogging", {"order": "24"})


class TestFrictionInExcessOfDryFriction:
    """A level that fades over all recorded speeds does what dry friction does: it does not take its place."""

    def test_it_is_no_candidate_without_dry_friction(self, stock):
        bare = stock.without_effect("coulomb_friction")
        h = null_hypothesis(bare)
        offered = {c.effect for c in candidates(h)}
        assert "coulomb_friction" in offered and "stribeck_friction" not in offered
        beside = h.with_effect("coulomb_friction", {"side": "motor"}, {"torque": 0.1})
        assert "stribeck_friction" in {c.effect for c in candidates(beside)}
        both = beside.with_effect("stribeck_friction", {"law": "gaussian"}, STRIBECK)
        dry, above = both.added
        assert (standing_on(both, dry), standing_on(both, above)) == ((above,), ())
        assert standing_on(beside, dry) == ()

    def test_dry_friction_of_the_model_lets_it_go_alone(self, stock):
        h = null_hypothesis(stock).with_effect("coulomb_friction", {"side": "motor"}, {"torque": 0.1})
        both = h.with_effect("stribeck_friction", {"law": "gaussian"}, STRIBECK)
        assert all(standing_on(both, name) == () for name in both.added)

    def test_dry_friction_that_a_model_lacks_is_named_as_that(self, stock):
        bare = stock.without_effect("coulomb_friction")
        found = discover(record(stock, ("triangle:0.06:2", "sine:0.05:0.4"), 10.0), bare)
        assert "coulomb_friction" in found.added and "stribeck_friction" not in found.added

    def test_it_goes_before_dry_friction_that_is_uncertain_beside_it(self, stock):
        """A level that fades over all speeds explains dry friction, which is then uncertain, and stays."""
        bare = stock.without_effect("coulomb_friction")
        problem = problem_of(record(stock, ("triangle:0.06:2", "sine:0.05:0.4"), 10.0), bare)
        null = null_hypothesis(bare)
        beside = null.with_effect("coulomb_friction", {"side": "motor"}, {"torque": 1e-6, "static_ratio": 1.0})
        beside = beside.with_effect("stribeck_friction", {"law": "gaussian"}, {"torque": 0.1, "speed": 1e3})
        both = fit(problem, beside, 0)
        turn = Round(fit(both.problem, null), (), both, tuple(beside.added))
        ended = significant(Search(both, (turn,)))
        assert "stribeck_friction" not in ended.fit.hypothesis.effects
        assert "coulomb_friction" in ended.fit.hypothesis.effects

"""Rivals: an effect that made another too uncertain beside it may be the wrong one of the two."""

from types import SimpleNamespace

from ema_twin_sim.discovery.discover import _tried
from ema_twin_sim.discovery.search.rivals import judged_against_rivals
from ema_twin_sim.discovery.search.search import less, settle, trial_of
from ema_twin_sim.discovery.search.trace import UNCERTAIN, Round, Search, Trial
from ema_twin_sim.identification.equation import EquationErrorProblem
from ema_twin_sim.identification.fit import fit
from ema_twin_sim.identification.hypothesis import null_hypothesis
from ema_twin_sim.measured.observation import observe_all
from tests.recorded import record


def test_a_load_that_was_uncertain_beside_gravity_takes_its_place(stock):
    """Over a part of a turn each is the other but for a little, and both together are uncertain."""
    recordings = record(stock.with_effect("constant_load", {"torque": 0.03}), ("triangle:0.06:2", "sine:0.03:0.4"))
    problem = EquationErrorProblem(observe_all(recordings, stock))
    bare = settle(fit(problem, null_hypothesis(stock)))
    both = bare.hypothesis.with_effect("constant_load", {}, {"torque": 0.01})
    both = both.with_effect("gravity_load", {}, {"torque": 0.01, "angle": 0.5})
    f = fit(bare.problem, both)
    found = Search(f, (Round(bare, (trial_of(bare, f),), f, ("constant_load", "gravity_load")),))
    without = less(found, ["constant_load"], UNCERTAIN)
    assert [*without.fit.hypothesis.added] == ["gravity_load"]
    end, _ = judged_against_rivals(without)
    assert [*end.fit.hypothesis.added] == ["constant_load"]


def test_a_trial_that_adds_nothing_is_not_told_of():
    """A fit from another start may win a round's trials without a name that a sentence could tell."""
    tried = tuple(Trial(names, SimpleNamespace(misfit=1.0), 2.0, 1.0) for names in ((), ("cogging",)))
    assert [told["names"] for told in _tried(Round(None, tried, None))] == [["cogging"]]

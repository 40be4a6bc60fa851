"""Rivals: an effect that made another too uncertain beside it may be the wrong one of the two."""

from ema_twin_sim.discovery.search.adding import settle, trial_of
from ema_twin_sim.discovery.search.removing import less
from ema_twin_sim.discovery.search.rivals import judged_against_rivals, swapped
from ema_twin_sim.discovery.search.trace import UNCERTAIN, Round, Search
from ema_twin_sim.identification.equation import EquationErrorProblem
from ema_twin_sim.identification.fit import fit
from ema_twin_sim.identification.hypothesis import null_hypothesis
from ema_twin_sim.measured.observation import observe_all
from tests.identification.test_wander import worn
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


def test_a_rival_that_holds_all_that_was_there_stands_in_for_nothing(stock):
    """A round tells of it alone: what was there has no name of its own beside it."""
    recordings = record(stock.with_effect("constant_load", {"torque": 0.03}), ("triangle:0.06:2",))
    problem = EquationErrorProblem(observe_all(recordings, stock))
    bare = settle(fit(problem, null_hypothesis(stock)))
    rival = fit(bare.problem, bare.hypothesis.with_effect("constant_load", {}, {"torque": 0.01}))
    (turn,) = swapped(Search(bare, ()), rival).rounds
    assert [trial.names for trial in turn.tried] == [("constant_load",)]


def spring_or_gravity(recordings, stock):
    """The effects that cannot be told from a spring, which was found in a search, by these recordings."""
    problem = EquationErrorProblem(observe_all(recordings, stock))
    bare = settle(fit(problem, null_hypothesis(stock)))
    spring, gravity = (
        fit(bare.problem, bare.hypothesis.with_effect(effect, {}, parameters))
        for effect, parameters in (
            ("spring_load", {"stiffness": 0.1}),
            ("gravity_load", {"torque": 0.1, "angle": 0.1}),
        )
    )
    found = Search(spring, (Round(bare, (trial_of(bare, spring), trial_of(bare, gravity)), spring, ("spring_load",)),))
    _, (rivalry,) = judged_against_rivals(found)
    return rivalry.group


def test_beside_friction_that_wanders_shapes_that_are_nearly_equal_are_told_as_a_group(stock):
    """Within a fifth of a turn, gravity differs from a spring by a few per cent: more than noise, less than that."""
    recordings = record(stock.with_effect("spring_load", {"stiffness": 0.06}), ("triangle:0.4:2", "sine:0.4:0.1"), 10.0)
    assert spring_or_gravity(recordings, stock) == ("spring_load",)
    assert spring_or_gravity(worn(recordings, 0.05, stock), stock) == ("gravity_load", "spring_load")

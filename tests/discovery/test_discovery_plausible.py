"""A wrong model is not dressed up: with the true effect left out, nothing else is named in its place."""

from dataclasses import replace

import pytest

from ema_twin_sim.discovery.criteria.explained import apart
from ema_twin_sim.discovery.criteria.plausible import insignificant, only_constants, strained
from ema_twin_sim.discovery.criteria.worth import has_effect_size, penalised_gain
from ema_twin_sim.discovery.diagnose import weigh
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.discovery.search import rivals
from ema_twin_sim.discovery.search.search import search
from ema_twin_sim.discovery.search.trace import Round, Search
from ema_twin_sim.effects import catalogue
from ema_twin_sim.effects.effect import QUANTITIES
from ema_twin_sim.identification.fit import fit
from ema_twin_sim.identification.null_hypothesis import null_hypothesis
from tests.problems import fit_of, hypothesis_of, problem_of
from tests.recorded import record

RUNS = ("ramp:0.05", "ramp:0.1", "triangle:0.06:2", "sine:0.05:0.4")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("id", "parameters", "depends_on"),
    [
        ("quadratic_drag", {"coefficient": 5e-4}, "speed"),
        ("added_inertia", {"inertia": 4e-4}, "acceleration"),
        ("torque_constant_error", {"scale": 0.75}, "speed"),
        ("gravity_load", {"torque": 0.06, "angle": 0.3}, "output_position"),
        ("encoder_eccentricity", {"amplitude": 2e-3, "phase": 1.0}, "encoders"),
        ("backlash", {"width": 0.003}, "encoders"),
    ],
)
def test_with_the_true_effect_left_out_nothing_is_named(id, parameters, depends_on, stock):
    found = discover(record(stock.with_effect(id, parameters), RUNS, 8.0), stock, without=(id,))
    assert (found.verdict, found.added) == ("unknown", ())
    assert depends_on in found.depends_on
    assert not found.parameters
    assert not found.groups


@pytest.mark.slow
def test_friction_curves_that_look_alike_are_told_apart_in_company(stock):
    """A Stribeck friction alone fits first, and would keep out the two that are there."""
    without_friction = stock.without_effect("coulomb_friction")
    true = stock.with_effect("quadratic_drag", {"coefficient": 5e-4})
    found = discover(record(true, RUNS), without_friction)
    assert found.verdict == "explained"
    assert set(found.added) == {"coulomb_friction", "quadratic_drag"}


def test_constants_far_from_their_file_are_noticed(stock):
    f = fit_of(record(stock, RUNS), stock)
    assert strained(f) == ()
    heavier = stock.with_value("machine.motor_inertia", 2.0 * stock.value("machine.motor_inertia"))
    assert strained(fit(f.problem, null_hypothesis(heavier))) == ("acceleration",)


def test_a_cause_for_each_constant_is_no_explanation(stock):
    """All torques off by one factor: without a torque constant, each number would need a cause of its own."""
    problem = problem_of(record(stock.with_effect("torque_constant_error", {"scale": 0.7}), RUNS), stock)
    found = search(problem, null_hypothesis(stock), frozenset({"torque_constant_error"}))
    assert len(only_constants(found.fit.problem, found.fit)) > 1
    two = null_hypothesis(stock).with_effect("viscous_friction", {"side": "motor"}, {"coefficient": 1e-3})
    two = two.with_effect("added_inertia", {}, {"inertia": 1e-5})
    assert only_constants(problem, fit(problem, two)) != ()
    without = null_hypothesis(stock.without_effect("viscous_friction"))
    one = without.with_effect("viscous_friction", {"side": "motor"}, {"coefficient": 0.02})
    assert only_constants(problem, fit(problem, one.with_effect("added_inertia", {}, {"inertia": 1e-5}))) == ()


@pytest.mark.parametrize("more", [0.10, 0.16, 0.17, 0.18, 0.25])
def test_an_inertia_that_is_worth_its_price_is_large_enough(more, stock):
    """Nothing but a constant off its file shows it: how large it is among the rows is no matter."""
    inertia = sum(stock.value(f"machine.{part}_inertia") for part in ("motor", "gearbox", "output"))
    added = {"inertia": more * inertia}
    before = fit_of(record(stock.with_effect("added_inertia", added), RUNS), stock, 20)
    problem = before.problem
    after = fit(problem, hypothesis_of(stock, added_inertia=added), 20)
    assert (penalised_gain(before, after) > 0.0) == has_effect_size(problem, before, after)
    assert has_effect_size(problem, before, after) == (more > 0.16)


def test_a_torque_constant_stands_behind_all_constants_or_none(stock):
    """One that is off, and half put right by a factor on all of them, tells nothing of the torque constant."""
    heavier = stock.with_effect("added_inertia", {"inertia": 4.6e-4})
    weaker = stock.with_effect("torque_constant_error", {"scale": 0.8})
    for machine, told in ((heavier, ("torque_constant_error",)), (weaker, ())):
        f = fit_of(record(machine, RUNS), stock, torque_constant_error={"scale": 0.9})
        assert only_constants(f.problem, f) == told


def test_encoders_that_part_less_than_before_may_part_too_much_still(stock):
    spring = {"stiffness": 20.0, "damping": 0.01}
    start = fit_of(record(stock.with_effect("shaft_compliance", spring), RUNS), stock)
    problem = start.problem
    assert apart(problem, fit(problem, hypothesis_of(stock, backlash={"width": 4e-5})), start)
    assert not apart(problem, fit(problem, hypothesis_of(stock, shaft_compliance=spring)), start)


def test_what_might_as_well_be_absent_is_not_sure(stock):
    for machine, goes in ((stock, "constant_load"), (stock.with_effect("constant_load", {"torque": 0.02}), None)):
        f = fit_of(record(machine, RUNS), stock, constant_load={"torque": 1e-4})
        assert insignificant(f.problem, f) == goes


def test_of_two_that_take_each_others_place_the_later_goes(stock):
    """Over a few degrees a weight is a constant load: neither is known beside the other, and one alone is."""
    recordings = record(stock.with_effect("constant_load", {"torque": 0.02}), ("triangle:0.01:2",))
    effects = {"constant_load": {"torque": 0.02}, "gravity_load": {"torque": 0.02, "angle": 1.57}}
    for order in (["constant_load", "gravity_load"], ["gravity_load", "constant_load"]):
        f = fit_of(recordings, stock, **{id: effects[id] for id in order})
        assert insignificant(f.problem, f) == order[-1]


def test_friction_goes_before_a_load_that_does_the_same(stock):
    """Where nothing reverses the two are one; every machine rubs, and few carry a weight."""
    one_way = record(stock, ("ramp:0.05", "ramp:0.1", "ramp:0.2"))
    found = discover(one_way, stock.without_effect("coulomb_friction"))
    assert found.added == ("coulomb_friction",)


@pytest.mark.parametrize(("behind", "stays"), [(-3.0, True), (-20.0, False)])
def test_friction_gives_way_to_a_load_that_is_surely_better_only(behind, stays, stock, monkeypatch):
    """By chance the one or the other is a little nearer, where nothing reverses."""
    without_friction = stock.without_effect("coulomb_friction")
    problem = problem_of(record(stock, ("ramp:0.05", "ramp:0.1")), without_friction)
    found = search(problem, null_hypothesis(without_friction))
    (friction,) = (rivalry for rivalry in rivals.rivalries(found) if rivalry.effect == "coulomb_friction")
    assert friction.runner_up == "constant_load"
    monkeypatch.setattr(rivals, "rivalries", lambda *_: (replace(friction, behind=behind),))
    monkeypatch.setattr(rivals, "penalised_gain", lambda *_: -behind)
    kept, _ = rivals.judged_against_rivals(found)
    assert ("coulomb_friction" in kept.fit.hypothesis.effects) == stays


def test_every_effect_of_the_catalogue_tells_over_what_it_shows():
    assert {effect.depends_on for effect in catalogue().values()} == set(QUANTITIES)


def test_a_bristle_that_no_recording_bends_is_not_sure(stock):
    """Its stiffness is open to both sides; as a softness it is as many standard errors from none as of itself."""
    bent = stock.with_effect("presliding_friction", {"stiffness": 4.0, "damping": 0.0})
    for machine, runs, goes in ((stock, ("ramp:0.05",), "presliding_friction"), (bent, RUNS, None)):
        f = fit_of(record(machine, runs), stock, presliding_friction={"stiffness": 1.0, "damping": 0.0})
        assert insignificant(f.problem, f) == goes


@pytest.mark.parametrize("scale", [0.87, 1.156])
def test_constants_that_were_put_back_do_not_make_an_effect_improbable(scale, stock):
    """The model ends with its file's constants where the loop follows as well; the equation may know better ones."""
    found = discover(record(stock.with_effect("torque_constant_error", {"scale": scale}), RUNS), stock)
    ranking = weigh(found).ranking
    assert {entry.effect for entry in ranking if entry.found} == {*found.added} == {"torque_constant_error"}
    assert ranking[0].probability > 0.9


def test_what_the_search_dropped_is_not_probable(stock):
    """Whatever it gains, and whatever gains nearly as much: the search had other reasons to say: nothing."""
    found = discover(record(stock.with_effect("stribeck_friction", {"torque": 0.06, "speed": 2.0}), RUNS), stock)
    (name,) = found.search.fit.hypothesis.added
    bare, beside = found.search.rounds[0].before, found.search.fit
    tried = found.search.rounds[0].tried
    assert sum(trial.gain > 0.0 for trial in tried) > 1
    came = Round(bare, tried, beside, (name,))
    dropped = Search(bare, (came, Round(beside, (), bare, (), (name,))))
    nothing = weigh(replace(found, verdict="none", added=(), search=dropped))
    assert {entry.effect: entry.probability for entry in nothing.ranking}["stribeck_friction"] == 0.0
    assert max(entry.probability for entry in nothing.ranking) < 0.1
    assert nothing.none > 0.9

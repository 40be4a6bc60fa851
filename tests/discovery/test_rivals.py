"""Rivals: an effect that made another too uncertain beside it may be the wrong one of the two."""

import math

import pytest

from ema_twin_sim.criteria import DECIDED, SUREST
from ema_twin_sim.discovery.diagnose import diagnose
from ema_twin_sim.discovery.search import rivals
from ema_twin_sim.discovery.search.adding import settle, trial_of
from ema_twin_sim.discovery.search.removing import less
from ema_twin_sim.discovery.search.rivals import Rivalry, came_near, judged_against_rivals, swapped, undecided
from ema_twin_sim.discovery.search.trace import SIMPLER, UNCERTAIN, Round, Search
from ema_twin_sim.identification.fit import fit
from ema_twin_sim.identification.generic_bases import beside_generic_bases
from ema_twin_sim.identification.separation import beside_its_wander, separation
from tests.identification.test_wander import worn
from tests.problems import fit_of
from tests.recorded import record


def test_a_load_that_was_uncertain_beside_gravity_takes_its_place(stock):
    """Over a part of a turn each is the other but for a little, and both together are uncertain."""
    recordings = record(stock.with_effect("constant_load", {"torque": 0.03}), ("triangle:0.06:2", "sine:0.03:0.4"))
    bare = settle(fit_of(recordings, stock))
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
    bare = settle(fit_of(recordings, stock))
    rival = fit(bare.problem, bare.hypothesis.with_effect("constant_load", {}, {"torque": 0.01}))
    (turn,) = swapped(Search(bare, ()), rival).rounds
    assert [trial.names for trial in turn.tried] == [("constant_load",)]


def test_an_effect_found_twice_is_certain_as_soon_as_one_of_them_is():
    """A slight wave beside a strong one might as well have been a load: cogging itself was said to be open."""

    def rivalry(effect, *others):
        return Rivalry(effect, "", math.inf, dict.fromkeys(others, 1.0), ())

    slight = rivalry("cogging", "constant_load")
    friction = rivalry("asymmetric_friction", "constant_load")
    assert undecided([rivalry("cogging"), slight, friction]) == (friction.group,)
    assert undecided([slight, slight, friction]) == (slight.group, friction.group)


def searched(recordings, stock, took, other):
    """A search that took one (effect, parameters) in a round where another was close."""
    bare = settle(fit_of(recordings, stock))
    first, second = (fit(bare.problem, bare.hypothesis.with_effect(id, {}, sizes)) for id, sizes in (took, other))
    return Search(first, (Round(bare, (trial_of(bare, first), trial_of(bare, second)), first, (took[0],)),))


SPRING = ("spring_load", {"stiffness": 0.06})
GRAVITY = ("gravity_load", {"torque": 0.1, "angle": 0.1})


def swinging(stock, missing, amplitude):
    """Recordings of a machine that lacks an effect and whose friction wanders; ``amplitude`` in rad of the output."""
    runs = (f"triangle:{amplitude}:2", f"sine:{amplitude}:0.1")
    return worn(record(stock.with_effect(*missing), runs, 10.0), 0.05, stock)


def test_of_shapes_that_are_nearly_equal_the_simplest_stands_if_something_is_unknown(stock):
    """Within a twentieth of a turn gravity is a spring and a constant load; a spring alone has one parameter."""
    found = searched(swinging(stock, SPRING, 0.1), stock, GRAVITY, SPRING)
    end, (rivalry,) = judged_against_rivals(found, beside_unknown=True)
    assert [*end.fit.hypothesis.added] == ["spring_load"] and rivalry.group == (GRAVITY[0], SPRING[0])
    assert [turn.reason for turn in end.rounds[1:]] == [SIMPLER]


def test_a_shape_that_is_surely_told_from_a_simpler_one_stands(stock):
    found = searched(swinging(stock, GRAVITY, 1.2), stock, GRAVITY, SPRING)
    end, (rivalry,) = judged_against_rivals(found, beside_unknown=True)
    assert [*end.fit.hypothesis.added] == ["gravity_load"] and rivalry.group == ("gravity_load",)


def test_a_torque_constant_that_is_refitted_is_no_rival(stock):
    """It is one of the model's own then, and there is but one."""
    found = searched(record(stock, ("triangle:0.06:2",)), stock, SPRING, ("torque_constant_error", {"scale": 1.02}))
    h = found.fit.hypothesis.with_effect("torque_constant_error", {}, {"scale": 1.01})
    best = h.with_factor_as_constant("torque_constant_error", 0.05)
    (turn,) = found.rounds
    assert [*came_near(found.fit.hypothesis, SPRING[0], turn, -math.inf)]
    assert not [*came_near(best, SPRING[0], turn, -math.inf)]


@pytest.mark.parametrize(("amplitude", "surely"), [(0.1, False), (1.2, True)])
def test_rows_tell_two_shapes_apart_the_more_surely_the_farther_they_swing(stock, amplitude, surely):
    (turn,) = searched(swinging(stock, SPRING, amplitude), stock, SPRING, GRAVITY).rounds
    spring, gravity = (trial.fit for trial in turn.tried)
    assert (separation(beside_its_wander(spring), gravity) > DECIDED) == surely


def test_what_depends_on_the_time_beside_both_is_no_obstacle(stock):
    """Its columns become noise of the same friction."""
    (turn,) = searched(swinging(stock, SPRING, 0.1), stock, SPRING, GRAVITY).rounds
    beside = beside_generic_bases(turn.before.problem, turn.before)
    columns = beside.generic_bases["time#0"].shape[1]
    spring, gravity = (fit(beside, trial.fit.hypothesis.with_generic_basis("time#0", columns)) for trial in turn.tried)
    assert separation(beside_its_wander(spring), gravity) < DECIDED


@pytest.mark.parametrize("angle", [0.1, 0.4])
@pytest.mark.parametrize(("amplitude", "told"), [(0.05, False), (0.2, False), (1.2, True)])
def test_an_arm_is_compared_with_a_spring_at_an_angle_of_its_own(stock, amplitude, angle, told):
    """From one place, rounds try springs relaxed there alone; over a part of a turn an arm is one relaxed elsewhere."""
    arm = ("gravity_load", {"torque": 0.1, "angle": angle})
    found = searched(swinging(stock, arm, amplitude), stock, arm, ("spring_load", {"stiffness": 0.1}))
    _, (rivalry,) = judged_against_rivals(found)
    assert rivalry.group == ((GRAVITY[0],) if told else (GRAVITY[0], SPRING[0]))
    own = next(f for f in rivalry.fits if f.hypothesis.added["spring_load"].options["relaxed"] == "angle")
    assert own.hypothesis.by_path["effects.spring_load.angle"] == pytest.approx(-angle, abs=0.1)


def test_a_simpler_load_that_would_cancel_another_takes_no_place(stock, monkeypatch):
    """A leg's load over its way was an arm of 13 N m and a constant load of -10, each of which is none of its own."""
    found = searched(swinging(stock, SPRING, 0.1), stock, GRAVITY, SPRING)
    monkeypatch.setattr(rivals, "opposed", lambda f: next((n for n in f.hypothesis.added if n == "spring_load"), None))
    end, _ = judged_against_rivals(found, beside_unknown=True)
    assert [*end.fit.hypothesis.added] == ["gravity_load"]


@pytest.mark.slow
@pytest.mark.parametrize(("amplitude", "surely"), [(0.1, False), (1.2, True)])
def test_what_shares_a_group_shares_its_probability(stock, amplitude, surely):
    """Whichever load explains a little more, it wins nearly every draw of the recordings' stretches."""
    found = diagnose(swinging(stock, GRAVITY, amplitude), stock)
    said = {entry.effect: entry.probability for entry in found.ranking}
    if surely:
        assert found.groups == () and said["gravity_load"] > 0.9
    else:
        (group,) = found.groups
        assert "gravity_load" in group and max(said[id] for id in group) < 0.9
        assert sum(said[id] for id in group) == pytest.approx(SUREST, abs=0.02)

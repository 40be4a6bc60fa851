"""A family is named by what measures it directly, and if it explains most of the change; otherwise none is."""

import numpy as np
import pytest

from ema_twin_sim.health import Family, judge_run
from ema_twin_sim.health.change import Change
from ema_twin_sim.health.families import DIRECT, DIRECTIONS, Ranked, rank
from ema_twin_sim.health.naming import Naming, agreed, name_change
from tests.health_by_hand import healthy_by_hand, run_by_hand

ALONE = healthy_by_hand(lacks=("lost_motion",))
"""Learnt with one encoder."""


@pytest.fixture(scope="module")
def baseline():
    return healthy_by_hand()


def judged(baseline, **off):
    """The judgement of one run without scatter, off by so many standard deviations."""
    return judge_run(run_by_hand("another", np.random.default_rng(2), scatter=0.0, **off), baseline)


@pytest.mark.parametrize(
    ("off", "family"),
    [
        ({"lost_motion": 30, "fast_roughness": 10, "bump": 6}, Family.PLAY),
        ({"friction": 20, "settling": 20, "rest_hunting": 18}, Family.FRICTION_UP),
        ({"friction": 20, "fast_roughness": -9, "rest_hunting": -9}, Family.PRELOAD_UP),
        ({"friction": -12, "settling": -9}, Family.FRICTION_DOWN),
        ({"bump": 12, "slow_roughness": 15, "settling": 6}, Family.LOCAL_DAMAGE),
        ({"load": 15, "breakaway": 6}, Family.LOAD),
    ],
)
def test_a_family_is_named_whose_direct_measure_moved(baseline, off, family):
    told = judged(baseline, **off)
    assert told.family is family and told.sureness > 0.75
    assert sum(one.probability for one in told.ranked) == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize("lost", [0, -8, -40])
def test_no_play_is_named_where_two_encoders_show_none(baseline, lost):
    """A machine that hunts and is rough has no play if the lost motion did not rise."""
    told = judged(baseline, fast_roughness=10, slow_roughness=10, rest_hunting=8, lost_motion=lost)
    assert told.detected and told.family is Family.UNKNOWN and told.sureness == 0.0
    assert all(one.family is not Family.PLAY for one in told.ranked)


def test_no_play_is_named_by_hunting_where_only_one_encoder_was_recorded():
    """Noise and the gain of the loop do the same; what changed most is told, with what can cause it."""
    told = judged(ALONE, lacks=("lost_motion",), fast_roughness=10, rest_hunting=8)
    assert told.family is Family.UNKNOWN and told.sureness == 0.0
    assert "explains: fast roughness by +" in told.words[-1] and " and hunting at rest by +" in told.words[-1]
    assert "Noise of a sensor, the gain of the control loop or play can cause it." in told.words[-1]


def test_lost_preload_measures_play_where_only_one_encoder_was_recorded():
    loose = {"friction": -6, "settling": -6, "rest_hunting": 7, "fast_roughness": 6}
    assert judged(ALONE, lacks=("lost_motion",), **loose).family is Family.PLAY
    assert judged(ALONE, lacks=("lost_motion",), **{**loose, "rest_hunting": 30}).family is Family.UNKNOWN


def test_no_family_is_named_that_leaves_what_changed_most():
    assert rank({"friction": 6.0, "settling": 5.0, "load": 0.3})[0].family is not Family.UNKNOWN
    assert rank({"friction": 6.0, "settling": 5.0, "load": 0.3, "lag": -16.0})[0].family is Family.UNKNOWN
    assert rank({"friction": 6.0, "settling": 5.0, "load": 0.3, "lag": 16.0})[0].family is not Family.UNKNOWN
    assert rank({"friction": 3.5, "load": 0.3, "lag": 16.0})[0].family is Family.UNKNOWN


def test_an_offset_of_the_effort_is_told_from_a_load_only_by_what_else_a_load_changes(baseline):
    told = judged(baseline, load=15)
    assert told.family is Family.LOAD and told.sureness < 0.6
    assert told.words[-1].startswith("This is a change of the load (probability ")
    assert "Alternatively an offset of the effort" in told.words[-1] and "zero of the current sensor" in told.words[-1]


def test_wind_up_grows_with_friction_and_is_no_play():
    """Lost motion that grows by the share of the effort is the effort's."""
    worn = {"friction": 6.0, "lost_motion": 9.0, "load": 0.2}
    wound = rank(worn, growths={"friction": 0.3, "lost_motion": 0.32})
    assert wound[0].family in (Family.FRICTION_UP, Family.PRELOAD_UP)
    assert all(one.family is not Family.PLAY for one in wound)
    assert rank({**worn, "lost_motion": 30.0}, growths={"friction": 0.3, "lost_motion": 1.1})[0].family is Family.PLAY


def test_efforts_that_changed_by_one_factor_are_told_and_named_no_family(baseline):
    """Friction, load and settling of 1.0, 0.1 and 0.5 A, each 40 % larger: in times of their scatter of 0.01 A."""
    told = judged(baseline, friction=40, load=4, settling=20, breakaway=12)
    assert told.family is Family.UNKNOWN and told.sureness == 0.0
    assert told.words[-1].startswith("All efforts changed by one factor of 1.40: check the current sensor and")
    assert judged(baseline, friction=40, settling=20, breakaway=12).family is not Family.UNKNOWN


def efforts(healthy, scatter, now):
    """Changes of efforts, by the healthy values, their scatter and the present values [A]."""
    return {
        name: Change(name, now[name], "A", healthy[name], (now[name] - healthy[name]) / scatter[name],
                     healthy[name] / scatter[name])
        for name in now
    }  # fmt: skip


HOIST = {"friction": 1.4, "load": 7.0, "settling": 7.0, "breakaway": 3.0}  # A
SCATTER = {"friction": 0.05, "load": 0.05, "settling": 0.05, "breakaway": 0.06}


def test_a_factor_that_friction_hides_is_no_load():
    """On a hoist friction scatters by more than a small factor changes it: a sensor's gain looks like a load."""
    scaled = {name: 1.05 * value for name, value in HOIST.items()}
    gain = name_change(efforts(HOIST, SCATTER, scaled), {}, unsigned=False)
    assert gain.family is Family.UNKNOWN
    assert gain.sentence.startswith("The load changed, or all efforts by one factor of 1.05")
    far = name_change(efforts(HOIST, SCATTER, {name: 1.2 * value for name, value in HOIST.items()}), {}, unsigned=False)
    assert far.sentence.startswith("All efforts changed by one factor of 1.20")


def test_a_load_is_told_from_a_factor_by_what_the_factor_would_have_changed():
    hung = {"friction": 1.4, "load": 7.7, "settling": 7.7, "breakaway": 3.0}
    assert name_change(efforts(HOIST, SCATTER, hung), {}, unsigned=False).family in (Family.LOAD, Family.OFFSET)
    heavy = {"friction": 1.42, "load": 9.0, "settling": 9.0, "breakaway": 3.8}
    assert name_change(efforts(HOIST, SCATTER, heavy), {}, unsigned=False).family is Family.LOAD


def test_efforts_that_fell_by_one_factor_while_the_breakaway_rose_have_no_factor():
    """What breaks away moved by a dozen standard deviations, but the other way: no factor of 0.8 did that."""
    fallen = {name: 0.8 * value for name, value in HOIST.items()}
    told = name_change(efforts(HOIST, SCATTER, fallen), {}, unsigned=False)
    assert told.sentence.startswith("All efforts changed by one factor of 0.80")
    risen = name_change(efforts(HOIST, SCATTER, {**fallen, "breakaway": 1.24 * 3.0}), {}, unsigned=False)
    assert "one factor" not in risen.sentence


def test_friction_of_two_speeds_is_no_load():
    """Viscous friction in moves of 1 and 2.2 rad/s: half the difference of both efforts is below half their sum."""
    healthy = {"friction": 0.1, "load": 0.01, "settling": 0.03}  # A
    scatter = {"friction": 2e-3, "load": 5e-4, "settling": 2e-3}
    for speeds in ((1.0, 2.2), (2.2, 1.0)):
        forward, backward = (0.012 * speed for speed in speeds)
        viscous = {"friction": 0.1 + 0.5 * (forward + backward), "load": 0.01 + 0.5 * (forward - backward)}
        told = name_change(efforts(healthy, scatter, {**viscous, "settling": 0.04}), {}, unsigned=False)
        assert told.family in (Family.FRICTION_UP, Family.PRELOAD_UP)
    half = {"friction": 0.11, "load": 0.03, "settling": 0.03}  # friction by half of what the load changed
    assert name_change(efforts(healthy, scatter, half), {}, unsigned=False).family is Family.UNKNOWN
    none = name_change(efforts(healthy, scatter, {**half, "friction": 0.1}), {}, unsigned=False)
    assert none.family in (Family.LOAD, Family.OFFSET)


def test_an_unsigned_effort_that_may_hold_a_load_names_no_friction():
    """A hoist: its effort has one sign both ways and is as large at rest, so more load and more friction look alike."""

    def change(name, value, healthy, off):
        return Change(name, value, "A", healthy, off, off * healthy / (value - healthy))

    hung = {"friction": change("friction", 13.0, 10.0, 90.0), "load": change("load", 1.02, 1.0, 0.3)}
    held = name_change({**hung, "settling": change("settling", 13.1, 10.1, 50.0)}, {}, unsigned=True)
    assert held.family is Family.UNKNOWN and "does not show whether load or friction changed" in held.sentence
    free = name_change({**hung, "settling": change("settling", 2.6, 2.0, 50.0)}, {}, unsigned=True)
    assert free.family in (Family.FRICTION_UP, Family.PRELOAD_UP)


def test_motions_of_a_test_are_named_apart():
    friction, play, unknown = (Naming((Ranked(family, 9.0, 0.9, ()),), family.value)
                               for family in (Family.FRICTION_UP, Family.PLAY, Family.UNKNOWN))  # fmt: skip
    assert agreed([(friction, 2), (unknown, 2)]) is friction
    assert agreed([(friction, 1), (unknown, 2)]) is unknown
    assert agreed([(friction, 2), (play, 3)]).family is Family.UNKNOWN


def test_a_change_that_hardly_shows_any_play_is_not_named_play():
    """Where no second encoder was recorded, effort that rises is no lost preload."""
    assert rank({"settling": 6.0, "rest_hunting": 1.7, "friction": 2.8, "load": 0.3})[0].family is Family.UNKNOWN


def test_several_weak_direct_measures_together_are_enough():
    weak = {"wave_depth": 2.4, "wave_both_ways": 2.4, "friction": -1.0, "load": 0.2}
    assert rank(weak)[0].family is Family.LOCAL_DAMAGE
    assert rank({**weak, "wave_both_ways": 0.0})[0].family is Family.UNKNOWN


def test_lost_motion_that_never_varies_shows_that_it_did_not_rise():
    """Its scatter is too small to judge its size by, but it was measured."""
    still = healthy_by_hand(still=("lost_motion",))
    assert "lost_motion" not in still.features
    off = {"fast_roughness": 10, "rest_hunting": 8, "still": ("lost_motion",)}
    assert judged(still, **off).family is Family.UNKNOWN
    assert judged(still, lost_motion=-1, **off).family is Family.UNKNOWN
    assert judged(still, lost_motion=1, **off).family is Family.PLAY


def test_friction_is_not_named_by_the_effort_after_a_stroke_alone(baseline):
    told = judged(baseline, settling=22, rest_hunting=5)
    assert told.family is Family.UNKNOWN
    assert (
        "Something changed that none of the families of damage explains: effort while settling after a stroke by"
        in told.words[-1]
    )


def test_a_family_that_leaves_most_of_the_change_is_not_named(baseline):
    """Lost motion that falls is no friction that rises, though friction is off a little."""
    told = judged(baseline, lost_motion=-25, friction=3)
    assert told.family is Family.UNKNOWN and told.ranked[0].probability > 0.9
    assert "none of the families of damage explains: lost motion between the encoders by -6" in told.words[-1]
    assert judged(baseline, lost_motion=-6, friction=25, settling=20).family is Family.FRICTION_UP


def test_a_wave_or_a_bump_that_falls_speaks_against_no_family():
    """Both are shares, of the effort and of the scatter: more friction makes them smaller."""
    worn = {"friction": 12.0, "slow_roughness": 20.0}
    alone, beside = (rank({**worn, "bump": bump, "wave_depth": wave})[0] for bump, wave in ((0.0, 0.0), (-15.0, -6.0)))
    assert alone == beside and alone.family is Family.FRICTION_UP


def test_scatter_of_healthy_runs_does_not_make_a_plain_fault_unknown():
    rng = np.random.default_rng(3)
    names = ["friction", "load", "settling", "fast_roughness", "slow_roughness", "rest_hunting", "bump", "wave_depth"]
    named = [rank({n: 8.0 * (n == "friction") + rng.standard_t(6) for n in names})[0].family for _ in range(200)]
    assert named.count(Family.UNKNOWN) <= 2
    assert np.mean([one in (Family.FRICTION_UP, Family.PRELOAD_UP) for one in named]) > 0.97


def test_each_direct_measure_is_one_of_its_family_s_directions():
    assert set(DIRECT) == set(DIRECTIONS)
    assert all(name in DIRECTIONS[family] for family, names in DIRECT.items() for name in names)
    assert rank({}) == ()

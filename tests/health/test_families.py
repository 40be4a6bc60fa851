"""A family is named by what measures it directly, and if it explains most of the change; otherwise none is."""

import numpy as np
import pytest

from ema_twin_sim.health import Family, judge_run
from ema_twin_sim.health.families import DIRECT, DIRECTIONS, rank
from tests.health_by_hand import healthy_by_hand, run_by_hand


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
        ({"load": 15}, Family.LOAD),
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


def test_play_is_named_where_only_one_encoder_was_recorded():
    alone = healthy_by_hand(lacks=("lost_motion",))
    assert judged(alone, lacks=("lost_motion",), fast_roughness=10, rest_hunting=8).family is Family.PLAY


def test_a_change_that_hardly_shows_any_play_is_not_named_play():
    """Where no second encoder was recorded, some feature of play has to be off likely."""
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

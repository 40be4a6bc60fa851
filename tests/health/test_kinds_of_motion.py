"""Each kind of motion has its own healthy recordings: a fault may show in one alone, and another motion is no fault."""

from dataclasses import replace

import numpy as np
import pytest

from ema_twin_sim.campaign.unit_health import JudgedTest, learnt_from
from ema_twin_sim.health import judge_run, learn_from
from ema_twin_sim.health.features import Feature
from tests.health_by_hand import run_by_hand

SLOW, FAST = (0.01, 10.0, 0.4), (0.01, 10.0, 2.0)


def moved(rng, motion, name="another", measured=True, **given):
    """A run by hand with this sample period [s], travel [rad] and top speed [rad/s]; or as its command says."""
    run = run_by_hand(name, rng, **given)
    if not measured:
        run.features.values["lag"] = Feature(float(-5.0 + 0.01 * rng.normal()), "rad", True, of_effort=False)
    return replace(run, motion=motion)


def both(rng, tests=12):
    return [moved(rng, motion, f"day {k}") for k in range(tests) for motion in (SLOW, FAST)]


def a_test(learnt, *runs):
    return JudgedTest("a test", tuple(map(learnt.judge, runs)), tuple(map(learnt.kind, runs)))


def test_a_fault_that_shows_in_the_slow_strokes_alone_makes_the_test_deviate():
    rng = np.random.default_rng(1)
    learnt = learnt_from(both(rng))
    fast = [moved(rng, FAST, scatter=0.005) for _ in range(4)]
    of = a_test(learnt, moved(rng, SLOW, friction=12.0), moved(rng, SLOW, friction=12.0), *fast)
    assert of.detected == 2 and of.judged == 6 and of.deviates and of.as_json()["deviates"]
    assert not a_test(learnt, moved(rng, SLOW, friction=12.0), moved(rng, SLOW, scatter=0.005), *fast).deviates


def test_kinds_of_motion_share_the_false_alarms():
    """Whichever of them calls a healthy test off: one in a hundred, as with one kind."""
    assert [one.false_alarm for one in learnt_from(both(np.random.default_rng(2))).kinds] == [0.005, 0.005]
    alarms = []
    for seed in range(20):
        rng = np.random.default_rng(100 + seed)
        learnt = learnt_from(both(rng, 20))
        alarms += [a_test(learnt, moved(rng, SLOW), moved(rng, FAST)).deviates for _ in range(40)]
    assert np.mean(alarms) <= 0.015


def test_a_motion_of_too_few_tests_takes_no_share():
    rng = np.random.default_rng(3)
    (learnt,) = learnt_from([*both(rng)[::2], moved(rng, FAST, "day 1")]).kinds
    assert learnt.false_alarm == 0.01


def test_a_motion_that_differs_is_told_beside_the_nearest_kind():
    rng = np.random.default_rng(4)
    learnt = learnt_from(both(rng))
    told = learnt.judge(moved(rng, (0.01, 10.0, 2.24)))
    assert told.detected is None
    assert "The top speed of 2.24 rad/s is 12% above that of the healthy recordings (2 rad/s)" in told.words[0]


@pytest.mark.parametrize(
    ("motion", "words"),
    [
        ((0.008, 10.0, 2.0), "The sample period of 0.008 s is 20% below"),
        ((0.01, 8.5, 2.0), "The travel of 8.5 rad is 15% below"),
        ((0.01, 10.0, 2.1), ""),
    ],
)
def test_a_motion_that_differs_by_more_than_healthy_ones_is_no_fault(motion, words):
    rng = np.random.default_rng(5)
    told = judge_run(moved(rng, motion, scatter=0.005), learn_from(both(rng)[1::2]))
    assert (told.detected is None) is bool(words) and words in told.words[0]


def test_a_command_repeats_better_than_what_a_machine_makes_of_it():
    rng = np.random.default_rng(6)
    learnt = learn_from([moved(rng, FAST, f"day {k}", measured=False) for k in range(12)])
    told = judge_run(moved(rng, (0.01, 10.0, 2.1), measured=False), learnt)
    assert told.detected is None and "The top speed of 2.1 rad/s is 5% above" in told.words[0]


def test_healthy_motions_that_scatter_allow_for_more():
    rng = np.random.default_rng(7)
    speeds = 2.0 * (1.0 + 0.05 * rng.normal(size=12))
    learnt = learn_from([moved(rng, (0.01, 10.0, speed), f"day {k}") for k, speed in enumerate(speeds)])
    assert judge_run(moved(rng, (0.01, 10.0, 2.24), scatter=0.005), learnt).detected is False
    assert learnt.motion_limits[0] == 0.02 and 0.12 < learnt.motion_limits[2] <= 0.25

"""Recordings that are wrong are told as such: cut, in another unit, or with their sign reversed. They name no fault."""

import re
from dataclasses import replace

import numpy as np
import pytest

from ema_twin_sim.health import MotionRecord, judge, judge_run, learn, learn_from
from ema_twin_sim.health.acquisition import Acquisition, Extent
from ema_twin_sim.health.features import Feature
from tests.health_by_hand import healthy_by_hand, run_by_hand

LASTING = Acquisition(True, True, False, (), Extent(20.0, 8))


@pytest.fixture(scope="module")
def baseline():
    return healthy_by_hand(acquisition=LASTING)


def judged(baseline, acquisition=LASTING, **given):
    made = run_by_hand("another", np.random.default_rng(3), acquisition=acquisition, scatter=0.005, **given)
    return judge_run(made, baseline)


def not_judged(told):
    """Whether nothing is said of the unit."""
    return told.detected is None and told.family is None and told.changes == () and len(told.words) == 1


@pytest.mark.parametrize(
    ("extent", "words"),
    [
        (Extent(12.0, 8), "The duration is 12 s and that of the healthy recordings 20 s. It may have been cut: repeat"),
        (Extent(20.0, 4), "The number of strokes is 4 and that of the healthy recordings 8. It may have been cut"),
        (Extent(45.0, 8), "The duration is 45 s and that of the healthy recordings 20 s. Repeat their test"),
    ],
)
def test_a_recording_that_holds_less_or_more_is_not_judged(baseline, extent, words):
    told = judged(baseline, acquisition=Acquisition(True, True, False, (), extent))
    assert not_judged(told) and words in told.words[0]


def test_a_recording_whose_extent_is_not_known_is_judged(baseline):
    """As those of results of earlier versions, and parts of a run that goes on."""
    assert judged(baseline, acquisition=Acquisition(True, True, False, ())).detected is False


@pytest.mark.parametrize(
    ("times", "words"),
    [
        (985.0, "Its efforts are all about 9[0-9]{2} times the healthy: is the current's unit mA, and not A?"),
        (0.00102, "Its efforts are all about 0.0010[0-9]* times the healthy: is the current's unit A, and not mA?"),
        (-1000.0, "Its efforts are all about [0-9]+ times the healthy"),
    ],
)
def test_an_effort_in_another_unit_is_not_judged(baseline, times, words):
    told = judged(baseline, times=abs(times), turned=times < 0.0)
    assert not_judged(told)
    assert re.search(words, told.words[0])


def test_an_effort_in_another_unit_is_told_beside_the_wave_of_a_machine_too():
    """A wave in per cent of the effort does not change with its unit."""

    def waving(rng, name, **given):
        run = run_by_hand(name, rng, acquisition=LASTING, **given)
        waves = {f"wave_{way}_{part}": Feature(0.1 + 0.001 * rng.normal(), "1") for way in ("forward", "backward")
                 for part in ("cos", "sin")}  # fmt: skip
        run.features.values.update(waves | {"wave_depth": Feature(20.0 + 0.1 * rng.normal(), "%")})
        return replace(run, wavelength=1.0)

    rng = np.random.default_rng(6)
    learnt = learn_from([waving(rng, f"day {k}") for k in range(12)])
    assert "wave_depth" in learnt.features
    told = judge_run(waving(rng, "another", times=1e-3), learnt)
    assert not_judged(told) and "is the current's unit A, and not mA?" in told.words[0]


def test_much_more_friction_alone_is_no_unit(baseline):
    """A jam takes a thousand times the effort, and the sensor's noise stays as it was."""
    told = judged(baseline, friction=99_900.0)
    assert told.detected and "unit" not in " ".join(told.words)


def test_an_effort_with_its_sign_reversed_is_not_judged(baseline):
    told = judged(baseline, turned=True)
    assert not_judged(told)
    assert "The mean effort against the motion is -1" in told.words[0] and "the sign of the current" in told.words[0]


def test_a_load_that_drives_one_way_has_no_reversed_sign(baseline):
    """What hangs on the output pulls the motion one way and hinders it the other."""
    told = judged(baseline, load=150.0)
    assert told.features["load"].value > told.features["friction"].value
    assert told.detected and told.family.value == "load"


def lasting(strokes, rng):
    """A run of so many strokes and rests."""
    time = np.arange(0.0, 3.0 * (2 * strokes), 0.02)
    corners = np.arange(2 * strokes + 1)
    command = np.interp(time, 3.0 * corners, 0.1 * ((corners + 1) // 2 % 2))
    effort = 3.0 * np.sign(np.gradient(command)) + 0.05 * rng.normal(size=len(time))
    position = command - 1e-3 * np.sign(np.gradient(command)) + 1e-5 * rng.normal(size=len(time))
    return MotionRecord(f"{rng.integers(1 << 30)}", f"{rng.integers(1 << 30)}", time, position, effort, command=command)


def test_the_extent_of_a_run_is_that_of_its_record():
    rng = np.random.default_rng(5)
    learnt = learn([lasting(4, rng) for _ in range(8)])
    assert {extent.strokes for extent in learnt.extents} == {4}
    assert learnt.extents[0].duration == pytest.approx(24.0, abs=0.1)
    assert judge(lasting(4, rng), learnt).detected is not None
    cut = judge(lasting(2, rng), learnt)
    assert cut.detected is None and "The duration is 12 s" in cut.words[0]

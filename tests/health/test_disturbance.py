"""What a place asks for, told from an effort that answers the error of the position."""

import numpy as np
import pytest

from ema_twin_sim.health import MotionRecord
from ema_twin_sim.health.disturbance import disturbance
from ema_twin_sim.health.wave import split_wave

LEAD = 0.01  # m
ROWS = np.arange(20, 180)


def stroke(rng, *, answer=400.0, scatter=5e-5, wave=0.03, given_by=0.0, command=True):
    """A stroke of a control that answers the error of this and the last sample; A and m."""
    time = 0.02 * np.arange(200.0)
    told = 0.05 * time
    place = 0.03 * np.cos(2.0 * np.pi * told / LEAD)
    error = scatter * rng.normal(size=len(time)) + given_by * place
    effort = 1.0 + wave / 0.03 * place + answer * (error + 0.5 * np.roll(error, 1))
    return MotionRecord("run", "test", time, told - error, effort, command=told if command else None)


def waves(count=200, **parts):
    """Phasors with what the error explains, and without it."""
    found = []
    for seed in range(count):
        record = stroke(np.random.default_rng(seed), **parts)
        place = record.position if record.command is None else record.command
        asked = disturbance(record, record.effort, ROWS, place, LEAD)
        found.append([split_wave(*one, LEAD)[0] for one in (asked, (record.effort[ROWS], place[ROWS]))])
    return np.array(found).T


def test_what_a_control_answers_is_no_torque_of_a_place():
    asked, plain = waves()
    assert np.mean(asked) == pytest.approx(0.03, rel=0.01) and np.mean(plain) == pytest.approx(0.03, rel=0.03)
    assert np.std(asked) < 0.1 * np.std(plain)


def test_an_effort_that_answers_nothing_keeps_its_wave():
    asked, plain = waves(answer=0.0)
    assert asked == pytest.approx(plain, abs=1e-4)


def test_an_error_that_only_waves_explains_nothing():
    """Its wave may be the effort's cause or its effect; without scatter nothing tells, and the effort stays."""
    asked, plain = waves(1, answer=0.0, scatter=1e-9, given_by=0.01)
    assert asked == pytest.approx(plain, rel=1e-3)


def test_without_a_command_or_with_few_rows_the_effort_stays():
    asked, plain = waves(1, command=False)
    assert np.array_equal(asked, plain)
    record = stroke(np.random.default_rng(1))
    effort, place = disturbance(record, record.effort, ROWS[:20], record.command, LEAD)
    assert np.array_equal(effort, record.effort[ROWS[:20]]) and np.array_equal(place, record.command[ROWS[:20]])
    still = MotionRecord("run", "test", record.time, record.command, record.effort, command=record.command)
    assert np.array_equal(disturbance(still, still.effort, ROWS, still.command, LEAD)[0], still.effort[ROWS])

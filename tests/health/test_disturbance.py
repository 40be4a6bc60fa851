"""What a place asks for, told from an effort that answers the error of the position."""

import numpy as np
import pytest
from numba import njit

from ema_twin_sim.health import Family, MotionRecord, baseline, judge_run, learn_from, run_features
from ema_twin_sim.health.disturbance import disturbance, tells_more
from ema_twin_sim.health.wave import wave_phasor

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
        found.append([wave_phasor([one], LEAD) for one in (asked, (record.effort[ROWS], place[ROWS]))])
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


@njit(cache=True)
def _driven(noise, gains, wave, friction, rate, told, speed):  # pragma: no cover
    """Positions and efforts of a unit mass on a screw, whose control answers the error of the position alone."""
    proportional, derivative, integral = gains
    at, moving, summed = told[0], 0.0, 0.0
    positions, efforts = np.zeros(len(told)), np.zeros(len(told))
    for k in range(len(told)):
        error = told[k] - at - 1e-6 * noise[0, k]
        summed += integral * error / rate
        effort = proportional * error + derivative * (speed[k] - moving) + summed
        positions[k], efforts[k] = told[k] - error, effort
        for _ in range(20):
            place = wave * np.cos(2.0 * np.pi * at / LEAD)
            moving += (effort - friction * np.tanh(moving / 1e-4) - place - 0.02 * noise[1, k]) / (20.0 * rate)
            at += moving / (20.0 * rate)
    return positions, efforts


def closed_loop(name, test, seed, *, wave, friction=1.0, rate, bandwidth, integral):
    """Out, rest and back, the wave and the friction in N, the rate and the bandwidth in Hz; as features."""
    time = np.arange(0.0, 12.0, 1.0 / rate)
    speed = np.where((time > 1.0) & (time < 5.0), 0.02, np.where((time > 6.0) & (time < 10.0), -0.02, 0.0))
    told = np.cumsum(speed) / rate
    quick = 2.0 * np.pi * bandwidth
    gains = quick**2, 1.8 * quick, 0.3 * quick**3 if integral else 0.0
    noise = np.random.default_rng(seed).normal(size=(2, len(told)))
    position, effort = _driven(noise, gains, wave, friction, float(rate), told, speed)
    return run_features(MotionRecord(name, test, time, position, effort, command=told), LEAD)


@pytest.mark.slow
@pytest.mark.parametrize("integral", [False, True], ids=["PD", "PID"])
@pytest.mark.parametrize(("rate", "bandwidth"), [(25, 2.0), (100, 2.0), (100, 5.0), (100, 15.0)])
def test_a_wave_that_only_the_control_tells_is_kept(monkeypatch, rate, bandwidth, integral):
    """Where all effort is an answer to the error, what errors explain is the wave of the place itself."""
    loop = {"rate": rate, "bandwidth": bandwidth, "integral": integral}
    rng = np.random.default_rng(0)
    healthy = []
    for test in range(10):
        friction = 1.0 + 0.02 * rng.normal()
        healthy += [
            closed_loop(
                "healthy", f"{test}", 10 * test + k, wave=0.01, friction=friction + 0.005 * rng.normal(), **loop
            )
            for k in range(5)
        ]
    worn = [closed_loop("worn", "worn", 900 + k, wave=0.02, **loop) for k in range(10)]

    def named():
        learnt = learn_from(healthy)
        families = [judge_run(run, learnt).family for run in worn]
        return sum(family is not None for family in families), families.count(Family.LOCAL_DAMAGE)

    assert not learn_from(healthy).freed
    found = named()
    monkeypatch.setattr(baseline, "tells_more", lambda *_: False)
    plain = named()
    assert found[0] >= plain[0] and found[1] >= plain[1]
    assert found[1] >= (5 if rate == 25 else 10)


@pytest.mark.parametrize(
    ("plain", "freed", "chosen"),
    [
        ((1.0, 0.2), (0.9, 0.1), True),
        ((1.0, 0.2), (0.6, 0.01), False),  # most of what is told of a place would be taken away
        ((1.0, 0.2), (0.9, 0.2), False),  # it scatters as before: nothing is gained
        ((0.01, 0.2), (0.01, 0.1), False),  # a healthy wave that is not known tells nothing
    ],
)
def test_waves_are_freed_of_errors_where_the_healthy_one_is_left(plain, freed, chosen):
    tests = [f"{k // 5}" for k in range(50)]
    scatter = np.random.default_rng(3).normal(size=(50, 4))
    waves = [size * np.array([0.5, -0.5, 0.5, 0.5]) + spread * scatter for size, spread in (plain, freed)]
    assert tells_more(*waves, tests) is chosen
    assert not tells_more(*waves, ["one"] * 50)


def test_it_matters_not_how_often_a_wave_is_sampled():
    """The errors that count are those of the wave's own time and no number of samples."""
    for rate in (20.0, 100.0, 500.0):
        time = np.arange(0.0, 8.0, 1.0 / rate)
        told, rng = 0.02 * time, np.random.default_rng(5)
        where = np.flatnonzero((time > 1.0) & (time < 7.0))
        left = []
        for _ in range(20):
            shaken = np.repeat(rng.normal(size=80), int(rate / 10.0))
            error = 5e-5 * np.convolve(np.pad(shaken, int(rate / 4), mode="edge"), np.ones(int(rate / 4)), "same")
            error = error[int(rate / 4) : -int(rate / 4)] / (rate / 4)
            effort = 1.0 + 0.03 * np.cos(2.0 * np.pi * told / LEAD) + 400.0 * error
            record = MotionRecord("run", "test", time, told - error, effort, command=told)
            both = disturbance(record, effort, where, told, LEAD), (effort[where], told[where])
            left.append([wave_phasor([one], LEAD) for one in both])
        asked, plain = np.array(left).T
        assert np.std(asked) < 0.2 * np.std(plain) and np.mean(asked) == pytest.approx(0.03, rel=0.02)

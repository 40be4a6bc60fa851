"""Which way a load's sensor counts is told by both directions of the motion, surely; else nothing is said."""

import numpy as np
import pytest

from ema_bench_replay.recording import POINTS, Recording
from ema_twin_sim.measured.load_sensor import falls_with_load, follows_load, load_varies, torque_per_current
from tests.recorded import sampled, with_signals

TIME = np.arange(8000) * 2e-3
SWINGS = 1.2 * 0.9 * np.cos(0.9 * TIME)
ONE_WAY = 3.0 + 0.5 * np.sin(0.9 * TIME)
LOAD = 2.0 + 0.8 * np.sin(0.37 * TIME + 1.0) + 0.5 * np.sin(2.3 * TIME)


def recorded(speed, torque, load, seed=1):
    random = np.random.default_rng(seed)
    signals = {
        "speed": speed,
        "current": torque + 0.01 * random.standard_normal(len(TIME)),
        "load_torque": load + 0.02 * random.standard_normal(len(TIME)),
    }
    return Recording("run", np.arange(len(TIME)) * 2_000_000, signals)


def friction(speed):
    return 0.7 * speed + 1.3 * np.sign(speed)


@pytest.mark.parametrize(("sign", "turned"), [(1.0, False), (-1.0, True)])
def test_a_sensor_that_counts_the_other_way_is_told(sign, turned):
    assert falls_with_load([recorded(SWINGS, friction(SWINGS) + LOAD, sign * LOAD)]) is turned


def test_a_screw_that_locks_itself_is_driven_down_against_its_load():
    """Up it takes more where the load is larger, and down it takes more too: it would hold by itself."""
    held = np.where(SWINGS > 0.0, 1.3, -0.4)
    assert not falls_with_load([recorded(SWINGS, friction(SWINGS) + held * LOAD, LOAD)])


def test_one_direction_tells_nothing():
    """Friction that falls as it warms up, beside the drift of a sensor that bears no load."""
    warming = -0.3 * TIME / TIME[-1]
    assert not falls_with_load([recorded(ONE_WAY, friction(ONE_WAY) + warming, -warming + 0.05 * LOAD)])


def test_chance_tells_nothing():
    random = np.random.default_rng(5)
    for seed in range(20):
        walk = np.cumsum(random.standard_normal(len(TIME))) * 0.02
        run = recorded(SWINGS, friction(SWINGS) + 0.05 * np.sin(1.7 * TIME), walk, seed)
        assert not falls_with_load([run])


def test_a_sensor_without_a_value_is_no_load():
    run = recorded(SWINGS, friction(SWINGS) + LOAD, LOAD)
    nothing = with_signals(run, {**run.signals, "load_torque": np.full(len(TIME), np.nan)})
    assert follows_load([nothing]) and not falls_with_load([nothing])


def held(torque, load, speed=0.0):
    """Operating points at rest, as of a motor whose output is clamped to a torque sensor, or at that ``speed``."""
    signals = {"speed": np.full(len(torque), speed), "current": torque, "load_torque": load}
    return Recording("held", np.arange(len(torque)) * 10**9, signals, metadata={POINTS: "yes"})


@pytest.mark.parametrize(("sign", "turned"), [(1.0, False), (-1.0, True)])
def test_a_few_points_at_rest_tell_it_as_well(sign, turned):
    torque = np.linspace(-20.0, 20.0, 12)
    load = 1.1 * torque - 0.006 * torque * np.abs(torque)
    assert falls_with_load([held(torque, sign * load)]) is turned
    assert not falls_with_load([held(torque[:6], sign * load[:6])])  # too few beside the numbers fitted to them
    scattered = load * np.random.default_rng(2).choice([-1.0, 1.0], len(load))
    assert not falls_with_load([held(torque, scattered)])


def test_points_of_a_screw_that_only_lowers_tell_nothing():
    """It locks itself: the heavier the load, the more torque drives it down."""
    load = np.linspace(10.0, 100.0, 20)
    assert not falls_with_load([held(-0.3 * load, load, speed=-5.0)])
    assert falls_with_load([held(-0.3 * load, load, speed=-5.0), held(-0.3 * load, load, speed=5.0)])


@pytest.mark.parametrize("load", [np.zeros(9), np.full(9, 2.0), np.full(9, np.nan)])
def test_a_load_that_does_not_change_is_none_to_tell_by(load):
    assert not load_varies(held(np.ones(9), load))
    assert load_varies(held(np.ones(9), np.arange(9.0)))


@pytest.mark.parametrize("seconds", [5.0, 600.0])
@pytest.mark.parametrize("zero", [0.0, 40.0])
@pytest.mark.parametrize(("swing", "varies"), [(0.0, False), (1.0, True)])
def test_noise_of_a_sensor_is_no_load_that_changes(swing, varies, zero, seconds):
    """However long the recording is, and wherever the sensor has its zero."""
    time = np.arange(0.0, seconds, 1e-3)
    load = zero + swing * np.sin(6.0 * time) + 0.1 * np.random.default_rng(4).standard_normal(len(time))
    moved = Recording("moved", (1e9 * time).astype(np.int64), {"current": np.ones(len(time)), "load_torque": load})
    assert load_varies(moved) is varies


def test_a_few_samples_of_motion_tell_no_noise():
    load = np.array([1.0, 2.0, 1.5])
    assert not load_varies(Recording("short", np.arange(3) * 10**6, {"current": load, "load_torque": load}))


@pytest.mark.parametrize(
    "load",
    [
        np.full(5000, 0.1),
        np.where(np.arange(5000) % 100 == 0, 0.01, 0.0),
        0.02 * np.linspace(0.0, 1.0, 5000) + 1e-3 * np.random.default_rng(1).standard_normal(5000),
    ],
    ids=["constant", "one digit now and then", "drift"],
)
def test_an_offset_is_no_load_that_changes(load):
    idle = Recording("idle", np.arange(5000) * 10**6, {"current": np.ones(5000), "load_torque": load})
    assert not load_varies(idle)


def test_the_factor_of_the_current_is_told_by_a_load_that_goes_with_it_alone():
    time = 1e-3 * np.arange(20_000)
    speed = 20.0 * np.sin(2.0 * time)
    load = np.interp(time, 0.7 * np.arange(30), np.random.default_rng(3).uniform(-1.0, 1.0, 30))
    current = (load + 0.02 * speed + 0.3 * np.tanh(speed) + 1e-3 * 40.0 * np.cos(2.0 * time)) / 1.9
    offset = 0.01 * np.sin(0.3 * time)
    for measured, factor in ((load, 1.9), (offset, None)):
        signals = {"current": current, "speed": speed, "load_torque": measured}
        told = torque_per_current([sampled("run", time, signals)])
        assert told == (None if factor is None else pytest.approx(factor, rel=0.05))

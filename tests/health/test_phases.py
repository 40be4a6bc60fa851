"""Which samples are strokes and rests, of made-up motions, and what features make of a coarse encoder."""

import numpy as np
import pytest

from ema_twin_sim.health import MotionRecord
from ema_twin_sim.health.encoders import encoders_apart
from ema_twin_sim.health.features import features_of
from ema_twin_sim.health.phases import phases_of

PERIOD = 0.01  # s


def run(speeds, rng, *, count=1e-3, noise=0.0003, hunting=0.02, loose=0.0):
    """A measured run of moves (speed rad/s, seconds) with ramps of 0.2 s, and rests of 1 s between them."""
    speed = [np.zeros(100)]
    for top, seconds in speeds:
        inside = np.arange(0.0, seconds, PERIOD)
        speed += [top * np.clip(np.minimum(inside, seconds - inside) / 0.2, 0.0, 1.0), np.zeros(100)]
    speed = np.concatenate(speed)
    place = np.cumsum(speed) * PERIOD
    position = count * np.round((place + noise * rng.normal(size=len(place))) / count)
    effort = np.sign(speed) + 0.2 * speed + hunting * rng.normal(size=len(place))
    motor = 50.0 * (place + loose * np.sign(speed))
    return MotionRecord("run", "test", PERIOD * np.arange(len(place)), position, effort, motor_position=motor)


def of_kinds(record):
    phases = phases_of(record)
    return tuple(len(phases.strokes(direction)) for direction in (1, -1, 0))


@pytest.mark.parametrize("share", [0.2, 0.48, 0.5, 0.52, 0.9])
def test_a_slow_move_between_two_rests_is_a_stroke_and_no_rest(share):
    for seed in range(5):
        record = run([(1.0, 3.0), (-1.0, 3.0), (share, 4.0)], np.random.default_rng(seed))
        assert of_kinds(record) == (2, 1, 4)
        assert max(np.ptp(record.position[piece.steady]) for piece in phases_of(record).strokes(0)) < 0.01


def test_a_move_that_hovers_about_half_of_its_top_speed_is_one_stroke():
    rng = np.random.default_rng(1)
    time = np.arange(0.0, 8.0, PERIOD)
    for seed in range(5):
        wander = 0.02 * np.convolve(np.random.default_rng(seed).normal(size=len(time) + 49), np.full(50, 0.14), "valid")
        speed = np.interp(time, [1, 1.2, 2, 2.2, 5, 5.2, 6, 6.2], [0, 1, 1, 0.5, 0.5, 1, 1, 0])
        position = np.cumsum(speed * (1.0 + wander)) * PERIOD
        record = MotionRecord("run", "test", time, position, speed + 0.01 * rng.normal(size=len(time)))
        assert of_kinds(record) == (1, 0, 2)


def test_the_turn_of_a_sine_is_no_rest():
    time = np.arange(0.0, 20.0, PERIOD)
    position = np.sin(0.3 * time)
    assert of_kinds(MotionRecord("run", "test", time, position, np.cos(0.3 * time)))[2] == 0


def test_an_encoder_that_ticks_between_two_counts_rests():
    """Its speed is far above a twentieth of the top speed at each tick."""
    for seed in range(5):
        record = run([(0.5, 3.0), (-0.5, 3.0)], np.random.default_rng(seed), count=1.5e-3, noise=0.3e-3)
        assert of_kinds(record) == (1, 1, 3)


def test_hunting_at_rest_does_not_fall_to_nothing_where_the_encoder_does_not_tick():
    """One count is one reading: whether it ticks at rest depends on where it stopped."""
    found = [
        features_of(run([(1.0, 3.0), (-1.0, 3.0)], np.random.default_rng(2), noise=noise), np.nan, False)
        .values["rest_hunting"].value
        for noise in (0.0, 0.0003)
    ]  # fmt: skip
    assert found[0] == pytest.approx(found[1], abs=0.5)
    least = 0.5 * np.log(0.02 * 1e-3 / np.sqrt(12.0))
    assert found[0] == pytest.approx(least, abs=0.1)


def test_one_wild_rest_counts_once():
    """As long as the others it would be all of their pooled scatter."""
    calm = run([(1.0, 3.0), (-1.0, 3.0), (1.0, 3.0)], np.random.default_rng(3))
    effort = calm.effort.copy()
    effort[-100:] *= 20.0
    wild = MotionRecord("wild", "test", calm.time, calm.position, effort)
    before, after = (features_of(one, np.nan, False).values["rest_hunting"].value for one in (calm, wild))
    assert after - before == pytest.approx(0.5 * np.log(20.0) / 4.0, abs=0.05)


def test_lost_motion_takes_each_stroke_once():
    """A long slow stroke has most of the samples, and an output that coasts floats in the gap."""
    record = run([(1.0, 3.0), (-1.0, 3.0), (0.2, 12.0), (-1.0, 2.5)], np.random.default_rng(4), loose=2e-3)
    slow = (record.time > 9.5) & (record.time < 21.5)
    motor = record.motor_position - 50.0 * 2e-3 * slow
    floated = MotionRecord("run", "test", record.time, record.position, record.effort, motor_position=motor)
    found = [encoders_apart(one, phases_of(one)).lost_motion for one in (record, floated)]
    assert found[0] == pytest.approx(2e-3, rel=0.1)
    assert found[1] == pytest.approx(1.5e-3, rel=0.15)

"""Stretches of time in which a machine was another: where they begin and end, what they brake, what is none."""

from types import SimpleNamespace

import numpy as np
import pytest

from ema_twin_sim.criteria import FAR_OUT
from ema_twin_sim.discovery.criteria.episodes import HOLES, SHORTEST, Episode, episodes, listed_episodes
from ema_twin_sim.plant.motion import SPEED, TIME

PERIOD, COUNT = 0.01, 1000
NOISE = 0.02  # N m
FAR = 1.5 * FAR_OUT


def recording(stretches, name="run", of_points=False, size=FAR, speed=3.0):
    """A recording of 10 s, and what is left of it in units of the noise: far out from one time to another [s]."""
    motion = np.zeros((COUNT, max(TIME, SPEED) + 1))
    motion[:, TIME] = PERIOD * np.arange(COUNT)
    motion[:, SPEED] = speed
    left = np.ones(COUNT)
    for start, end in stretches:
        left[round(start / PERIOD) : round(end / PERIOD) + 1] = size
    held = SimpleNamespace(
        name=name, of_points=of_points, motion=motion, rows=np.arange(COUNT), torque_noise=np.full(COUNT, NOISE)
    )
    return held, left


def found(*recordings):
    held, left = zip(*recordings, strict=True)
    parts = [slice(k * COUNT, (k + 1) * COUNT) for k in range(len(held))]
    problem = SimpleNamespace(observations=list(held), torque_parts=parts)
    return episodes(problem, SimpleNamespace(raw=np.concatenate(left)))


def test_one_is_told_with_its_times_and_its_mean_torque():
    (one,) = found(recording([(4.0, 5.5)]))
    assert (one.recording, one.start, one.end) == ("run", pytest.approx(4.0), pytest.approx(5.5))
    assert one.torque == pytest.approx(FAR * NOISE)


@pytest.mark.parametrize("size", [FAR, -FAR])
@pytest.mark.parametrize("speed", [3.0, -3.0])
def test_what_brakes_the_motion_counts_as_positive(size, speed):
    (one,) = found(recording([(4.0, 5.0)], size=size, speed=speed))
    assert one.against == pytest.approx(size * NOISE * np.sign(speed))
    assert one.torque == pytest.approx(size * NOISE)


def test_what_stays_within_the_noise_is_none():
    assert found(recording([(4.0, 5.5)], size=0.99 * FAR_OUT)) == ()


def test_a_spike_is_none():
    assert found(recording([(4.0, 4.0 + SHORTEST - 2 * PERIOD)])) == ()
    assert len(found(recording([(4.0, 4.0 + SHORTEST + 2 * PERIOD)]))) == 1


def test_a_hole_parts_two_only_where_it_is_long():
    near = [(4.0, 4.5), (4.5 + HOLES - 2 * PERIOD, 5.5)]
    apart = [(4.0, 4.5), (4.5 + HOLES + 2 * PERIOD, 5.5)]
    assert [(one.start, one.end) for one in found(recording(near))] == [pytest.approx((4.0, 5.5))]
    assert len(found(recording(apart))) == 2


def test_a_machine_that_is_another_all_along_has_none():
    assert found(recording([(0.0, 5.1)])) == ()
    assert len(found(recording([(0.0, 4.8)]))) == 1


def test_single_rows_far_out_here_and_there_are_no_episode_and_hide_one():
    """Where most of what is far out comes and goes within a moment, it is no matter of time."""
    moments = [(0.5 * k, 0.5 * k) for k in range(8, 18)]
    assert len(found(recording([(1.0, 1.5), *moments]))) == 1
    assert found(recording([(1.0, 1.12), *moments, *((at + 0.25, at + 0.25) for at, _ in moments)])) == ()


def test_points_of_a_table_have_no_order_in_time():
    told = found(recording([(4.0, 5.0)], "table", of_points=True), recording([(6.0, 7.0)]))
    assert [one.recording for one in told] == ["run"]


def test_the_longest_are_listed_in_order_of_time_in_seconds_of_the_machine():
    every = [Episode("run", float(k), k + 0.1 + 0.05 * (k % 4), 0.1, 0.1) for k in range(8)]
    told = listed_episodes(every, most=3, second=2.0)
    assert told == "run from 4.00 s to 4.40 s, run from 6.00 s to 6.50 s, run from 14.00 s to 14.50 s, and 5 more"
    assert listed_episodes(every[:1]) == "run from 0.00 s to 0.10 s"

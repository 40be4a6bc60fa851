"""A twin that follows a bench sample by sample gives what the offline simulation gives."""

import math

import numpy as np
import pytest

from ema_bench_replay.load import load
from ema_bench_replay.sample import VALUES
from ema_twin_sim.live.follower import Follower
from ema_twin_sim.live.sample_stream import Kind
from ema_twin_sim.simulation.simulate import simulate

UNKNOWN = dict.fromkeys(VALUES, math.nan)


@pytest.fixture(scope="module")
def recording(traces):
    return load(next(path for path in traces if "triangle" in path.name)).between(0.0, 2.0)


def samples(recording):
    for index in range(len(recording)):
        values = {name: column.item(index) for name, column in recording.signals.items()}
        yield index, recording.start + int(recording.stamps[index]), UNKNOWN | values | recording.origins


def follow(follower, recording, run=1):
    answers = [follower.answer(run, index, stamp, sample) for index, stamp, sample in samples(recording)]
    return {name: np.array([answer[name] for answer in answers]) for name in answers[0]}


@pytest.mark.parametrize("source", ["setpoint", "current"])
def test_equals_the_offline_simulation(recording, stock, source):
    offline = simulate(stock, recording, source)
    followed = follow(Follower(stock, source), recording)
    for name, values in offline.signals.items():
        np.testing.assert_array_equal(followed[name], values, err_msg=name)


def test_a_second_run_gives_the_same(recording, stock):
    follower = Follower(stock)
    first = follow(follower, recording)
    second = follow(follower, recording, run=2)
    np.testing.assert_array_equal(first["current"], second["current"])
    assert (follower.stream.runs, follower.answered) == (2, 2 * len(recording))


def test_auto_takes_the_setpoint_where_there_is_one(recording, stock):
    follower = Follower(stock)
    follow(follower, recording.between(0.0, 0.1))
    assert follower.input == "setpoint"
    sample = next(samples(recording))[2] | {"speed_setpoint": math.nan}
    follower.answer(2, 0, 1, sample)
    assert follower.input == "current"


def test_a_bench_without_the_driving_signal_is_a_problem_until_it_comes(recording, stock):
    follower = Follower(stock, "setpoint")
    mute = next(samples(recording))[2] | {"speed_setpoint": math.nan}
    assert follower.answer(1, 0, 1, mute) is None
    assert "speed_setpoint" in follower.problem
    assert follower.answer(1, 1, 2_000_001, mute | {"speed_setpoint": 1.0}) is not None
    assert follower.problem == ""


def test_positions_may_begin_anywhere(recording, stock):
    part = recording.between(0.0, 0.5)
    at_zero = follow(Follower(stock), part)
    shift = {"motor_position": 1000.0, "output_position": 8.0}
    follower = Follower(stock)
    for index, stamp, sample in samples(part):
        answer = follower.answer(1, index, stamp, sample | {name: sample[name] + by for name, by in shift.items()})
    for name, by in shift.items():
        assert answer[name] - by == pytest.approx(at_zero[name][-1], abs=1e-9)
    assert answer["current"] == pytest.approx(at_zero["current"][-1], abs=1e-9)


def test_a_gap_is_integrated_across(recording, stock):
    whole = follow(Follower(stock, "current"), recording)
    follower = Follower(stock, "current")
    for index, stamp, sample in samples(recording):
        if not 300 <= index < 310:
            answer = follower.answer(1, index, stamp, sample)
    assert follower.stream.lost == 10
    assert answer["motor_position"] == pytest.approx(whole["motor_position"][-1], abs=0.05)


def test_what_is_left_out_is_not_answered(recording, stock):
    follower = Follower(stock)
    first, second = [entry for entry, _ in zip(samples(recording), range(2), strict=False)]
    assert follower.answer(1, *first) is not None
    assert follower.answer(1, *second) is not None
    assert follower.answer(1, *second) is None
    assert follower.stream.accept(1, *second[:2]) is Kind.LEFT_OUT


def test_a_parameter_acts_on_the_next_sample(recording, stock):
    plain, changed = Follower(stock), Follower(stock)
    for index, stamp, sample in samples(recording.between(0.0, 0.2)):
        if index == 50:
            changed.twin.change({"effects.stribeck_friction.enabled": True})
        one, other = plain.answer(1, index, stamp, sample), changed.answer(1, index, stamp, sample)
        assert (one["current"] == other["current"]) == (index < 50), index

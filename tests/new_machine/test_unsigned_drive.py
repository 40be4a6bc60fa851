"""A current that is a magnitude is told from one that a load keeps positive, whatever its column is called."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import KIND
from ema_twin_sim.model.matching import matched
from ema_twin_sim.new_machine.unsigned_drive import unsigned_signals
from ema_twin_sim.simulation.simulate import choose_input
from tests.recorded import sampled
from tests.taken_columns import guessed

TIME = np.arange(4000) * 2e-3
SPEEDS = {
    "sines": 20.0 * np.sin(1.3 * TIME) + 5.0 * np.sin(4.0 * TIME),
    "steps": 20.0 * np.tanh(5.0 * np.sin(0.8 * TIME)),
}


def current(speed, load_torque, dry, inertia=5e-3, viscous=0.01):
    noise = 0.02 * np.random.default_rng(5).normal(size=len(TIME))
    return load_torque + dry * np.tanh(2.0 * speed) + viscous * speed + inertia * np.gradient(speed, TIME) + noise


def recorded(speed, drive, signal="current", motion="speed"):
    noise = 0.05 * np.random.default_rng(6).normal(size=len(TIME))
    way = np.cumsum(speed) * 2e-3
    moves = {"speed": speed + noise} if motion == "speed" else {motion: way - way[0]}
    return sampled("r", TIME, {**moves, signal: drive})


@pytest.mark.parametrize("name", SPEEDS)
@pytest.mark.parametrize("motion", ["speed", "motor_position"])
@pytest.mark.parametrize(
    ("load_torque", "dry", "inertia", "viscous"),
    [(0.0, 0.2, 5e-3, 0.01), (0.0, 2.0, 5e-3, 0.01), (0.1, 0.2, 5e-3, 0.01), (0.0, 0.2, 0.0, 0.0)],
)
def test_a_magnitude_is_told(name, motion, load_torque, dry, inertia, viscous):
    drive = current(SPEEDS[name], load_torque, dry, inertia, viscous)
    assert unsigned_signals([recorded(SPEEDS[name], np.abs(drive), motion=motion)]) == {"current"}
    assert not unsigned_signals([recorded(SPEEDS[name], drive, motion=motion)])


def test_a_torque_may_be_one_too():
    drive = np.abs(current(SPEEDS["sines"], 0.0, 0.5))
    assert unsigned_signals([recorded(SPEEDS["sines"], drive, signal="motor_torque")]) == {"motor_torque"}


@pytest.mark.parametrize("name", SPEEDS)
@pytest.mark.parametrize("motion", ["speed", "motor_position"])
@pytest.mark.parametrize("dry", [0.05, 0.2, 1.0, 2.0])
def test_a_load_that_always_pulls_one_way_keeps_a_current_positive(name, motion, dry):
    drive = current(SPEEDS[name], 3.0, dry)
    assert drive.min() > 0.0
    assert not unsigned_signals([recorded(SPEEDS[name], drive, motion=motion)])


@pytest.mark.parametrize("dry", [0.0, 0.02, 1.0])
def test_a_level_arm_keeps_a_current_positive(dry):
    """Its load over the angle falls both ways, as a magnitude does towards each reversal."""
    speed = 0.6 * np.cos(2.0 * TIME)
    drive = 3.0 * np.cos(0.3 * np.sin(2.0 * TIME)) + dry * np.sign(speed)
    assert not unsigned_signals([recorded(speed, drive, motion="motor_position")])


def test_one_direction_does_not_tell():
    speed = 20.0 + 5.0 * np.sin(1.3 * TIME)
    assert not unsigned_signals([recorded(speed, np.abs(current(speed, 0.0, 0.5)))])


def test_a_machine_at_rest_does_not_tell():
    drive = np.full(len(TIME), 0.5)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        still = sampled("r", TIME, {"speed": np.zeros(len(TIME)), "current": drive})
        assert not unsigned_signals([still])
        drive[::7] = 0.0
        assert not unsigned_signals([still])


def test_a_negative_value_in_another_recording_is_a_sign():
    drive = current(SPEEDS["sines"], 0.0, 0.5)
    both = [recorded(SPEEDS["sines"], np.abs(drive)), recorded(SPEEDS["sines"], drive)]
    assert not unsigned_signals(both)


def one_way(way, drive_of, load_torque=0.0, fast=1.0, period=2e-3):
    """A start, a run and a stop in one direction, at a rate of its own; ``drive_of`` makes what is recorded of it."""
    time = np.arange(2000) * period
    speed = way * fast * 10.0 * (np.tanh(time / (60.0 * period) - 6.0) - np.tanh(time / (60.0 * period) - 26.0))
    drive = load_torque + 0.2 * np.tanh(2.0 * speed) + 0.01 * speed + 5e-3 * np.gradient(speed, period)
    turned = np.cumsum(speed) * period
    noise = 0.02 * np.random.default_rng(7).normal(size=len(time))
    signals = {"motor_position": 0.02 * np.rint((turned - turned[0]) / 0.02), "current": drive_of(drive) + noise**2}
    return sampled(f"r{way}", time, signals)


@pytest.mark.parametrize("rates", [(2e-3, 2e-3), (2e-3, 8e-3)])
@pytest.mark.parametrize("loads", [(0.0, 0.0), (0.1, 0.05)])
def test_a_magnitude_is_told_by_recordings_that_go_one_way_each(rates, loads):
    runs = [one_way(way, np.abs, load, period=period) for way, load, period in zip((1, -1), loads, rates, strict=True)]
    assert not any(unsigned_signals([run]) for run in runs)
    assert unsigned_signals(runs) == {"current"}
    assert not unsigned_signals([one_way(way, lambda drive: drive) for way in (1, -1)])


@pytest.mark.parametrize("loads", [(3.0, 3.0), (2.5, 4.0)])
def test_a_lift_with_a_brake_keeps_its_sign_in_recordings_of_one_way_each(loads):
    """The brake holds at rest, so that the current goes down to zero there; each run may have a load of its own."""
    runs = []
    for way, load_torque in zip((1, -1), loads, strict=True):
        run = one_way(way, lambda drive: drive, load_torque)
        moves = np.abs(np.gradient(run.signals["motor_position"])) > 0.0
        held = np.convolve(moves, np.ones(101), "same") == 0.0
        runs.append(replace(run, signals={**run.signals, "current": np.where(held, 0.0, run.signals["current"])}))
        assert runs[-1].signals["current"].min() == 0.0
    assert not unsigned_signals(runs)


def test_runs_of_the_same_way_do_not_tell():
    assert not unsigned_signals([one_way(1, np.abs), one_way(1, np.abs, fast=0.5)])


def test_single_negative_samples_are_noise_and_two_in_a_row_are_a_sign():
    drive = np.abs(current(SPEEDS["sines"], 0.0, 0.5))
    drive[[500, 502, 1700]] = -0.3
    assert unsigned_signals([recorded(SPEEDS["sines"], drive)]) == {"current"}
    drive[501] = -0.3
    assert not unsigned_signals([recorded(SPEEDS["sines"], drive)])


def test_init_says_so_of_files_of_one_way_each(drafted):
    runs = []
    for way in (1, -1):
        run = one_way(way, np.abs)
        values = run.signals["current"].copy()
        values[700] = -0.1
        runs.append({"time [s]": run.time, "angle [rad]": run.signals["motor_position"], "current [A]": values})
    draft = drafted(*runs, torque_constant=0.05)
    assert "current [A]: never negative but for single samples, so it looks like a magnitude" in draft.warned
    assert "magnitude: true" in draft.map


def sines(name, drive):
    return {"time [s]": TIME, "motor speed [rad/s]": SPEEDS["sines"], name: drive}


@pytest.mark.parametrize("name", ["current [A]", "supply current [A]", "I_dc [A]", "bus current [A]"])
def test_init_reads_it_as_a_magnitude_whatever_its_name(drawn, drafted, read, name):
    draft = drafted(sines(name, np.abs(current(SPEEDS["sines"], 0.0, 0.5))), torque_constant=0.05)
    assert draft.warned.count(f"{name}: never negative, so it looks like a magnitude without sign") == 1
    assert "positive drives forwards" not in draft.said and "ema-twin discover" not in draft.said
    assert f"{name} has no sign, so no twin can be driven: only the health can be judged" in draft.said
    assert "magnitude: true" in draft.map
    assert read().metadata[f"current{KIND}"] == "magnitude"
    drawn()


def test_a_twin_is_refused_for_the_missing_sign_and_not_for_a_missing_column(drawn, drafted, read):
    """It said to map a column as current, which the map did."""
    drafted(sines("current [A]", np.abs(current(SPEEDS["sines"], 0.0, 0.5))))
    model = drawn()
    recording = matched(read(), model)
    with pytest.raises(InputError, match=r"reads current as a magnitude\. .*take `magnitude: true` out") as refused:
        choose_input(recording, model)
    assert "Map a column" not in str(refused.value)


def test_a_supply_current_that_has_a_sign_is_not_the_motors(drafted):
    assert "  current:" not in drafted(sines("supply current [A]", current(SPEEDS["sines"], 0.0, 0.5))).map


def test_a_motor_current_goes_before_that_of_the_supply():
    numbers = {"t": TIME, "I_mot [A]": np.sin(TIME), "supply current [A]": np.ones_like(TIME)}
    (guess,) = guessed(numbers).signals
    assert guess.column == "I_mot [A]" and not guess.magnitude


def test_short_moves_with_long_rests_tell_a_magnitude_too():
    """A bus servo logs whole steps of its current at 10 Hz: zero in most rows, those around each move included."""
    time = np.arange(400) * 0.1
    at = np.repeat([0.0, 1.0, 0.0, -1.0] * 5, 20)
    position = np.round(1000.0 * at - 300.0 * (np.r_[0.0, np.diff(at)]))
    drive = np.round(30.0 * np.abs(np.r_[0.0, np.diff(at)]) + 6.0 * (at > 0.0) * np.abs(np.r_[np.diff(at), 0.0]))
    run = sampled("r", time, {"motor_position": position, "current": drive})
    assert np.median(drive) == 0.0 and drive.min() == 0.0
    assert unsigned_signals([run]) == {"current"}


@pytest.mark.parametrize("dry", [0.2, 1.0])
def test_the_noise_of_a_magnitude_goes_below_zero_where_the_machine_rests(dry, drafted):
    """An analog sensor of a servo's supply current: its noise made it a current with a sign, and that a load."""
    moves = np.where(np.sin(2.0 * TIME) > 0.5, 1.0, 0.0) - np.where(np.sin(2.0 * TIME) < -0.5, 1.0, 0.0)
    speed = 20.0 * np.convolve(moves, np.ones(50) / 50.0, "same")
    true = current(speed, 0.0, dry)
    noise = 0.05 * np.random.default_rng(7).normal(size=len(TIME))
    magnitude = np.abs(true) * (speed != 0.0) + noise
    assert ((magnitude[1:] < 0.0) & (magnitude[:-1] < 0.0)).any()
    assert unsigned_signals([recorded(speed, magnitude, motion="motor_position")]) == {"current"}
    assert not unsigned_signals([recorded(speed, true + noise, motion="motor_position")])
    way = np.cumsum(speed) * 2e-3
    draft = drafted({"time [s]": TIME, "motor position [rad]": way, "current [A]": magnitude})
    assert "never negative but for its noise, so it looks like a magnitude" in draft.warned


@pytest.mark.parametrize(
    ("weight", "dry", "viscous", "inertia", "noise", "turns"),
    [
        (0.67, 0.3, 0.007, 1e-3, 0.281, 1.05),
        (0.33, 0.13, 0.0, 0.0, 0.089, 4.94),
        (0.7, 0.19, 0.021, 1e-2, 0.185, 0.66),
        (0.86, 0.14, 1e-3, 1e-3, 0.486, 1.39),
        (0.63, 0.23, 1e-3, 0.0, 0.206, 1.85),
    ],
)
@pytest.mark.parametrize("back", [1.0, 0.25])
def test_a_load_over_the_position_leaves_a_noisy_current_its_sign(weight, dry, viscous, inertia, noise, turns, back):
    """Under a load that goes down to zero on the way, a current is negative in stretches that noise nearly hides."""
    time = 5e-3 * np.arange(4000)
    speed = 20.0 * np.sin(turns * time)
    speed[speed < 0.0] *= back
    way = np.cumsum(speed) * 5e-3
    drive = weight * np.abs(np.sin(way / 3.0)) + dry * np.sign(speed) + viscous * speed
    drive += inertia * np.gradient(speed, time) + noise * np.random.default_rng(8).normal(size=len(time))
    signals = {"motor_position": way, "current": drive}
    assert (drive < 0.0).any()
    assert not unsigned_signals([sampled("r", time, signals)])


def test_a_current_that_noise_hides_in_each_sample_shows_its_sign_in_stretches():
    speed = SPEEDS["steps"]
    drive = 0.5 + 0.9 * np.tanh(2.0 * speed) + 0.4 * np.random.default_rng(9).normal(size=len(TIME))
    assert not unsigned_signals([recorded(speed, drive)])

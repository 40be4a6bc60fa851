"""A speed that is a difference of counts: the motion is taken from the position, and the inertia is not too small."""

import math
from dataclasses import replace

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.measured.quieter_motion import as_measured
from ema_twin_sim.model import load_model
from ema_twin_sim.model.own_units import OwnUnits, recording_in
from tests.open_motor import open_motor
from tests.recorded import sampled

PERIOD = 1e-3  # s
COUNTS = 10_000  # per revolution
COUNT = 2.0 * math.pi / COUNTS
INERTIA, VISCOUS, DRY, GRAVITY = 1e-3, 5e-3, 0.05, 0.3
NOISE = 0.01  # A, at 1 N m/A


def swung(rate=3.0, speed_noise=None, seed=1):
    """A motor with a weight swings: position in counts, speed as their difference unless its noise [rad/s] is given."""
    random = np.random.default_rng(seed)
    time = np.arange(10_000) * PERIOD
    fast, slow = 2.0 * math.pi * rate, 2.0 * math.pi * 0.4 * rate
    angle = 1.2 * np.sin(fast * time) + 1.5 * np.sin(slow * time)
    speed = 1.2 * fast * np.cos(fast * time) + 1.5 * slow * np.cos(slow * time)
    acceleration = -1.2 * fast**2 * np.sin(fast * time) - 1.5 * slow**2 * np.sin(slow * time)
    torque = INERTIA * acceleration + VISCOUS * speed + DRY * np.sign(speed) + GRAVITY * np.sin(angle)
    position = COUNT * np.round(angle / COUNT)
    if speed_noise is None:
        read = np.diff(position, prepend=position[0] - COUNT) / PERIOD
    else:
        read = speed + speed_noise * random.standard_normal(len(time))
    signals = {"current": torque + NOISE * random.standard_normal(len(time)), "speed": read, "motor_position": position}
    return Recording("swung", np.arange(len(time)) * 1_000_000, signals, motor_angle_origin=0.0)


@pytest.fixture(scope="module")
def motor():
    return open_motor(1.0, NOISE, PERIOD, motor_encoder_counts=float(COUNTS), speed_noise=0.2)


def test_the_integral_of_a_speed_is_no_second_sensor(motor):
    """It was told to be integrated, since there is no position, and to be left out for the position, both at once."""
    given = swung()
    alone = replace(given, signals={name: values for name, values in given.signals.items() if "position" not in name})
    (found,) = as_measured([alone], motor)
    assert found.has("speed", "motor_position")
    assert len(found.warnings) == 1 and "its speed is integrated instead" in found.warnings[0]
    assert [one.warnings for one in as_measured([found], motor)] == [found.warnings]


def test_a_speed_of_single_counts_is_left_out_and_said_so(motor):
    given = [swung(), swung(rate=2.0)]
    found = as_measured(given, motor)
    assert [{*one.signals} - {*other.signals} for one, other in zip(given, found, strict=True)] == [{"speed"}] * 2
    assert "swung and 1 more: the speed is too noisy for the acceleration" in found[0].warnings[-1]
    assert not found[1].warnings
    assert [one.warnings for one in as_measured(found, motor)] == [one.warnings for one in found]  # said so once


@pytest.mark.parametrize("times", [30.0 / math.pi, math.pi / 180.0, 1e3, -1.0])
def test_a_speed_in_another_unit_stays_and_is_refused(times, motor):
    """Left out for its noise, it would hide a wrong unit, or a wrong time, on a machine of unknown inertia."""
    given = swung()
    given = replace(given, signals={**given.signals, "speed": times * given.signals["speed"]})
    assert as_measured([given], motor)[0].has("speed")
    with pytest.raises(InputError, match=r"speed is .* times what motor_position makes it|motor_position is .* times"):
        discover([given], motor)


@pytest.mark.parametrize("recording", [swung(speed_noise=2e-3), swung(speed_noise=0.0)])
def test_a_quiet_speed_stays(recording, motor):
    assert as_measured([recording], motor) == [recording]


def test_a_noisy_speed_stays_where_the_position_is_coarser_still(motor):
    """A fifth of a turn is told apart, no less: its second derivative is noisier than the speed's first."""
    coarse = motor.with_value("sensors.motor_encoder_counts", 20.0)
    recording = swung(speed_noise=1.0)
    assert as_measured([recording], coarse) == [recording]


def test_one_answer_for_recordings_of_the_same_sensors(motor):
    """A slow swing alone hardly accelerates; beside a fast one the same speed is good enough for both."""
    slow, fast = swung(rate=0.1, speed_noise=0.2), swung(rate=8.0, speed_noise=0.2)
    assert [one.has("speed") for one in as_measured([slow, fast], motor)] == [True, True]
    assert not as_measured([slow], motor)[0].has("speed")


def test_a_machine_at_another_scale_keeps_what_a_similar_one_keeps(motor):
    units = OwnUnits(time=7.0, torque=0.2, current=0.2)
    for noise in (None, 2e-3):
        (found,) = as_measured([recording_in(swung(speed_noise=noise), units)], motor)
        assert found.has("speed") == (noise is not None)


def test_a_long_pause_and_missing_values_cost_no_memory(motor):
    given = swung()
    stamps = given.stamps + np.where(np.arange(len(given)) > 5000, 86_400 * 1_000_000_000 * 30, 0)
    speed = given.signals["speed"].copy()
    speed[::7] = np.nan
    paused = replace(given, stamps=stamps, signals={**given.signals, "speed": speed})
    assert not as_measured([paused], motor)[0].has("speed")


def test_a_weight_is_found_behind_a_speed_of_single_counts(motor):
    found = discover([swung(seed=k, rate=rate) for k, rate in enumerate((2.0, 3.0))], motor)
    assert found.added == ("gravity_load",)
    torque = found.parameters["gravity_load"]["torque"]
    assert torque["value"] == pytest.approx(GRAVITY, rel=0.03)
    inertia = next(iter(found.constants["machine"].values()))
    assert inertia["value"] == pytest.approx(INERTIA, rel=0.03)


def test_recordings_without_a_position_are_told_in_one_line():
    """It was a line for each of them."""
    time = np.arange(2000) * 1e-3
    signals = {"speed": np.sin(5.0 * time), "current": np.cos(5.0 * time)}
    runs = [sampled(f"r{k}", time, signals, warnings=(f"r{k}: of its own",)) for k in range(35)]
    found = as_measured(runs, load_model("laas_motor"))
    told = "r0 and 34 more: has no position; its speed is integrated instead, and angles count from its start"
    assert found[0].warnings == ("r0: of its own", told)
    assert [one.warnings for one in found[1:]] == [one.warnings for one in runs[1:]]
    assert all(one.has("motor_position") for one in found)
    alone = as_measured(runs[3:4], load_model("laas_motor"))
    assert alone[0].warnings[1] == told.replace("r0 and 34 more", "r3")

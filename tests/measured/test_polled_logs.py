"""Logs of a computer that polls a drive: no even clock, and readings that repeat."""

import math
from dataclasses import replace

import numpy as np
import pytest

from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.model import load_model
from ema_twin_sim.reading_noise import polled_noise
from tests.recorded import sampled

DRY, VISCOUS, INERTIA, NOISE = 0.35, 0.23, 0.05, 0.03  # N m, N m s/rad, kg m^2, N m


@pytest.mark.parametrize("polled", [1, 7])
def test_the_noise_of_a_sensor_that_is_polled_faster_than_it_reads(polled):
    time = np.arange(4000) * 1e-3
    readings = np.sin(3.0 * time) + 0.01 * np.random.default_rng(1).standard_normal(len(time))
    assert polled_noise(np.repeat(readings, polled)) == pytest.approx(0.01, rel=0.1)


def test_what_never_changes_has_no_noise():
    assert polled_noise(np.full(100, 3.0)) == 0.0


def test_the_last_digit_of_coarse_readings_is_no_noise():
    """A speed in steps of 0.06 rad/s, written with six decimals: in slow motion most third differences are its last."""
    step, rest, ramp = 2.0 * np.pi / 100.0, np.zeros(1600), np.arange(2400)
    shaken = ramp + np.rint(np.random.default_rng(5).standard_normal(len(ramp))) * (ramp > 500)
    exact = step * np.concatenate([rest, shaken])
    written = np.round(exact, 6)
    assert polled_noise(written) == pytest.approx(polled_noise(exact), rel=0.01)
    assert polled_noise(written) > 0.3 * step


def logged(seed, seconds=70.0):
    """A joint goes to and fro with long rests, logged every 31 ms or so, and sometimes not for 90 ms."""
    random = np.random.default_rng(seed)
    steps = random.choice([0.029, 0.031, 0.033, 0.062, 0.092], 4000, p=[0.35, 0.35, 0.14, 0.1, 0.06])
    time = np.cumsum(steps)
    time = time[time < seconds] - time[0]
    rate = 2.0 * math.pi * 0.2
    phase = np.minimum(time % 20.0, 5.0)  # a period of motion, then 15 s at rest
    angle = 0.4 * (1.0 - np.cos(rate * phase))
    speed, acceleration = 0.4 * rate * np.sin(rate * phase), 0.4 * rate**2 * np.cos(rate * phase) * (phase < 5.0)
    torque = INERTIA * acceleration + VISCOUS * speed + DRY * np.tanh(speed / 1e-2)
    signals = {"current": torque + NOISE * random.standard_normal(len(time)), "speed": speed, "motor_position": angle}
    return sampled(f"joint_{seed}", time, signals, motor_angle_origin=0.0)


def test_a_slow_uneven_log_is_judged():
    model = load_model("laas_motor").with_value("machine.torque_constant", 1.0)
    model = model.with_value("sensors.current_noise", NOISE).with_value("sensors.sample_period", 0.031)
    model = model.with_value("machine.motor_inertia", 1e-3)
    model = model.with_effect("coulomb_friction", {"torque": 1.0}).with_effect("viscous_friction", {"coefficient": 1.0})
    model = replace(model, effects={name: replace(held, open=True) for name, held in model.effects.items()})
    found = discover([logged(1)], model)
    assert found.added == ()
    told = {name: next(iter(numbers.values())) for name, numbers in found.constants.items()}
    for name, true in (("coulomb_friction", DRY), ("viscous_friction_2", VISCOUS)):  # that motor has a little, too
        assert abs(told[name]["value"] - true) < 3.0 * told[name]["std"]
        assert told[name]["std"] < 0.5 * true

"""A speed with much noise: kernels are as wide as its acceleration needs, and the inertia is not too small."""

from dataclasses import replace

import numpy as np
import pytest

from ema_bench_replay.recording import Recording
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.measured.observe import observe, observe_all
from tests.open_motor import open_motor

PERIOD, SECONDS = 1e-3, 20.0
CONSTANT, READING = 0.0458, 0.5  # N m/A; A, noise of the current
INERTIA, VISCOUS, DRY = 1.2e-4, 7e-5, 0.03


def stepped(speed_noise, sign=1.0, second=0.05, seed=1):
    """A motor follows two steps of torque; its speed is read with a noise [rad/s]."""
    random = np.random.default_rng(seed)
    time = np.arange(round(SECONDS / PERIOD)) * PERIOD
    torque = sign * np.where(time < SECONDS / 2, 0.04, second)
    speed, decay = np.zeros(len(time)), np.exp(-VISCOUS / INERTIA * PERIOD)
    for k in range(1, len(time)):
        towards = (torque[k] - sign * DRY) / VISCOUS
        speed[k] = towards + (speed[k - 1] - towards) * decay
    signals = {
        "current": torque / CONSTANT + READING * random.standard_normal(len(time)),
        "speed": speed + speed_noise * random.standard_normal(len(time)),
        "motor_position": np.cumsum(speed) * PERIOD,
    }
    return Recording(f"stepped_{seed}", np.arange(len(time)) * 1_000_000, signals)


def recordings(speed_noise):
    steps = ((1.0, 0.05), (1.0, 0.055), (-1.0, 0.05), (-1.0, 0.055))
    return [stepped(speed_noise, sign, second, seed) for seed, (sign, second) in enumerate(steps)]


@pytest.fixture(scope="module")
def motor():
    return open_motor(CONSTANT, READING, PERIOD)


@pytest.mark.slow
@pytest.mark.parametrize("speed_noise", [0.0, 0.1, 0.6])
def test_the_inertia_is_right_whatever_the_noise(motor, speed_noise):
    """It was 0.17 of 1.2 g dm2 with 0.6 rad/s, and something was said to be missing that depends on the speed."""
    model = motor.with_value("sensors.speed_noise", speed_noise)
    found = discover(recordings(speed_noise), model)
    inertia = found.constants["machine"]["inertia"]
    assert (found.verdict, found.added) == ("none", ())
    assert inertia["value"] == pytest.approx(INERTIA, abs=3.0 * inertia["std"])
    assert inertia["std"] < 0.1 * INERTIA


def test_kernels_are_no_wider_than_the_noise_needs(motor):
    given = recordings(0.6)
    for noise, wider in ((0.0, False), (0.6, True)):
        model = motor.with_value("sensors.speed_noise", noise)
        usual = observe(given[0], model)
        told = observe_all(given if noise else recordings(0.0), model)
        assert [len(o.kernel) > len(usual.kernel) for o in told] == [wider] * 4
        left = sum(o.acceleration_noise**2 * len(o.rows) for o in told)
        assert left < 0.0101 * sum(float(o.acceleration @ o.acceleration) for o in told)


def test_a_machine_that_does_not_accelerate_keeps_its_kernels(motor):
    """No kernel shows an acceleration where there is none, and a wide one would hide ripple."""
    steady = [replace(one, signals={**one.signals, "speed": _steady(one)}) for one in recordings(0.6)]
    model = motor.with_value("sensors.speed_noise", 0.6)
    assert [len(o.kernel) for o in observe_all(steady, model)] == [len(observe(one, model).kernel) for one in steady]


def test_a_recording_too_short_for_wide_kernels_keeps_the_usual_ones(motor):
    """It was refused as too short, which it was not before."""
    model = motor.with_value("sensors.speed_noise", 0.6)
    first, *others = recordings(0.6)
    signals = {name: values[:500] for name, values in first.signals.items()}
    short = replace(first, name="short", stamps=first.stamps[:500], signals=signals)
    assert [o.name for o in observe_all([short, *others], model)] == ["short", *(one.name for one in others)]


def _steady(one):
    """A speed of 300 rad/s with a noise of 0.6 rad/s, in the direction of a recording."""
    noise = 0.6 * np.random.default_rng(5).standard_normal(len(one))
    return np.sign(one.signals["current"].mean()) * 300.0 + noise

"""An encoder of few counts, as a hall sensor or a slotted disc has: its inertia is not too small."""

import math
from dataclasses import replace

import numpy as np
import pytest

from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.measured.balance_estimate import estimate_balance
from ema_twin_sim.measured.held_readings import noise_of_held, noise_of_readings, samples_held
from ema_twin_sim.measured.scales import rms_torque
from tests.open_motor import open_motor
from tests.recorded import sampled

CONSTANT, READING = 0.05, 0.02  # N m/A; A, noise of the current
INERTIA, VISCOUS, DRY = 5e-4, 4e-4, 0.01


def counted(counts, period, seed=1):
    """A motor swings back and forth; its position is read in whole counts, of so many a turn."""
    random = np.random.default_rng(seed)
    time = np.arange(round(20.0 / period)) * period
    slow, fast = 25.0 + 3.0 * seed, 12.0
    speed = slow * np.sin(1.1 * time) + fast * np.sin(5.0 * time + seed)
    acceleration = 1.1 * slow * np.cos(1.1 * time) + 5.0 * fast * np.cos(5.0 * time + seed)
    torque = INERTIA * acceleration + VISCOUS * speed + DRY * np.sign(speed)
    angle = -slow / 1.1 * np.cos(1.1 * time) - fast / 5.0 * np.cos(5.0 * time + seed)
    count = 2.0 * math.pi / counts
    signals = {
        "current": torque / CONSTANT + READING * random.standard_normal(len(time)),
        "motor_position": count * np.floor(angle / count),
    }
    return sampled(f"counted_{seed}", time, signals)


def hall_motor(counts, period):
    return open_motor(CONSTANT, READING, period, motor_encoder_counts=counts)


@pytest.mark.parametrize("counts", [42.0, 200.0, 5000.0])
@pytest.mark.parametrize("period", [2e-4, 1e-3])
def test_the_first_estimate_of_an_inertia_needs_no_fine_encoder(counts, period):
    """With kernels of some samples the noise of 42 counts made it a ten-thousandth, and that the kernels narrower."""
    given, model = [counted(counts, period)], hall_motor(counts, period)
    found = estimate_balance(given, model, rms_torque(given, model))
    assert found.inertia == pytest.approx(INERTIA, rel=0.1)


def test_nor_a_speed_that_is_computed_as_often_as_it_is_logged():
    """Third differences of samples see nothing of a noise of 1 rad/s that is held for eight of them."""
    fine = counted(1e6, 1e-3)
    time = fine.time
    speed = np.gradient(fine.signals["motor_position"], 1e-3)
    held = (speed + np.random.default_rng(4).standard_normal(len(time)))[np.arange(len(time)) // 8 * 8]
    given = [replace(fine, signals={**fine.signals, "speed": held})]
    model = hall_motor(1e6, 1e-3)
    assert noise_of_readings(held) == pytest.approx(math.sqrt(8.0), rel=0.1)
    assert estimate_balance(given, model, rms_torque(given, model)).inertia == pytest.approx(INERTIA, rel=0.1)


def test_a_long_recording_of_a_coarse_counter_is_no_longer_work():
    """The kernels widen until the motion fades in them, and are evaluated where they are needed."""
    time = 1e-3 * np.arange(300_000)
    angle = -0.25 * np.cos(20.0 * time)
    speed, acceleration = 5.0 * np.sin(20.0 * time), 100.0 * np.cos(20.0 * time)
    torque = INERTIA * acceleration + VISCOUS * speed + DRY * np.sign(speed)
    count = 2.0 * math.pi / 42.0
    signals = {"current": torque / CONSTANT, "motor_position": count * np.floor(angle / count)}
    given = [sampled("long", time, signals)]
    found = estimate_balance(given, hall_motor(42.0, 1e-3), rms_torque(given, hall_motor(42.0, 1e-3)))
    assert found is not None and found.inertia < 2.0 * INERTIA


@pytest.mark.slow
@pytest.mark.parametrize("counts", [42.0, 200.0])
def test_nothing_is_missing_where_the_encoder_is_coarse(counts):
    found = discover([counted(counts, 1e-3, seed) for seed in (1, 2)], hall_motor(counts, 1e-3))
    inertia = found.constants["machine"]["inertia"]
    assert (found.verdict, found.added) == ("none", ())
    assert inertia["value"] == pytest.approx(INERTIA, abs=3.0 * inertia["std"])
    assert inertia["std"] < 0.05 * INERTIA


def test_a_reading_is_held_until_it_changes():
    assert samples_held(np.repeat(np.arange(10.0), 8)) == 8.0
    assert samples_held(np.arange(10.0)) == 1.0
    assert samples_held(np.zeros(10)) == 1.0  # it never changes
    assert noise_of_held(0.5, np.repeat(np.arange(10.0), 4)) == pytest.approx(1.0)


def test_a_speed_that_changes_now_and_then_is_no_held_reading():
    to_and_fro = np.sign(np.sin(0.01 * np.arange(5000.0) + 0.1))
    assert noise_of_readings(to_and_fro) == 0.0
    noisy = to_and_fro + 0.1 * np.random.default_rng(6).standard_normal(5000)
    assert noise_of_readings(noisy) == pytest.approx(0.1, rel=0.1)


def test_a_held_noise_is_as_large_after_a_wide_kernel_as_it_says():
    random = np.random.default_rng(2)
    held = np.repeat(random.standard_normal(5000), 6)
    kernel = np.full(120, 1.0 / 120.0)
    left = float(np.std(np.convolve(held, kernel, "valid")))
    assert left == pytest.approx(noise_of_held(1.0, held) * float(np.linalg.norm(kernel)), rel=0.1)

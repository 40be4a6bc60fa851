"""A swing whose acceleration nearly goes with the angle: a load over the angle does not become a huge inertia."""

import math
from dataclasses import replace

import numpy as np
import pytest

from ema_bench_replay.recording import Recording
from ema_twin_sim.measured.balance_estimate import estimate_balance
from ema_twin_sim.measured.noise import noise_of
from ema_twin_sim.measured.scales import rms_torque
from tests.large_arm import open_arm

INERTIA, VISCOUS, COULOMB, STRIBECK, LATCH = 38.0, 90.0, 45.0, 55.0, 70.0
STEP, EVERY = 5e-4, 4


def _latch(angle):
    """Torque [N m] that pulls an arm to 0.13 rad when it comes near: a shape that no load of the estimate has."""
    away = (angle - 0.13) / 0.012
    return LATCH * away * math.exp(0.5 - 0.5 * away * away)


def swing(model, size):
    """An arm that a speed controller swings, and whose speed the latch disturbs; inertia and torques times ``size``."""
    random = np.random.default_rng(20)
    angle, speed, integral, rows = 0.02, 0.0, 0.0, []
    for step in range(round(24.0 / STEP)):
        error = 0.1 * math.sin(1.26 * step * STEP) - speed
        integral += 2600.0 / 0.03 * error * STEP
        torque = 2600.0 * error + integral
        if step % EVERY == 0:
            rows.append((torque, speed, angle))
        free = speed + STEP * (torque - VISCOUS * speed - _latch(angle)) / INERTIA
        held = STEP * (COULOMB + STRIBECK * math.exp(-abs(speed) / 0.004)) / INERTIA
        speed = math.copysign(max(abs(free) - held, 0.0), free)
        angle += STEP * speed
    torque, speed, angle = np.array(rows).T
    noisy = torque + 1.2 * random.standard_normal(len(torque))
    signals = {
        "current": size * noisy / model.value("machine.torque_constant"),
        "speed": speed + 2e-4 * random.standard_normal(len(speed)),
        "motor_position": angle,
    }
    stamps = np.arange(len(torque)) * round(1e9 * STEP * EVERY)
    return Recording("swing", stamps, signals, motor_angle_origin=0.0, output_angle_origin=0.0)


def arm_with_sensors(size):
    model = replace(open_arm(INERTIA * size), effects={}).with_effect("coulomb_friction", {"torque": COULOMB * size})
    noise = 1.2 * size / model.value("machine.torque_constant")
    return model.with_value("sensors.current_noise", noise).with_value("sensors.speed_noise", 2e-4)


@pytest.mark.parametrize("size", [1e-3, 1.0])
def test_a_load_of_another_shape_is_not_taken_for_a_huge_inertia(size):
    """It was 80 times the inertia, and so was the noise floor of the unexplained torque."""
    model = arm_with_sensors(size)
    recordings = [swing(model, size)]
    found = estimate_balance(recordings, model, rms_torque(recordings, model))
    assert found is not None and 0.5 < found.inertia / (INERTIA * size) < 2.0
    known = {path: replace(held, tolerance=0.0) for path, held in model.constants.items() if "inertia" in path}
    right = noise_of(recordings, replace(model, constants={**model.constants, **known}))
    assert noise_of(recordings, model)["unexplained_torque"] < 2.0 * right["unexplained_torque"]


def test_an_inertia_that_little_besides_the_angle_shows_is_found_where_nothing_is_missing():
    """The acceleration goes with the angle here as well, but no unknown torque is left that could stand for it."""
    model = arm_with_sensors(1.0)
    time = np.arange(12_000) * 2e-3
    random = np.random.default_rng(2)
    angle, speed, acceleration = (
        0.5 * 1.26**k * np.sin(1.26 * time + k * math.pi / 2) + 0.005 * 5.0**k * np.sin(5.0 * time + k * math.pi / 2)
        for k in range(3)
    )
    torque = INERTIA * acceleration + 300.0 * np.sin(angle) + COULOMB * np.sign(speed)
    signals = {
        "current": (torque + 1.2 * random.standard_normal(len(time))) / model.value("machine.torque_constant"),
        "speed": speed + 2e-4 * random.standard_normal(len(time)),
        "motor_position": angle,
    }
    stamps = np.arange(len(time)) * 2_000_000
    recordings = [Recording("swing", stamps, signals, motor_angle_origin=0.0, output_angle_origin=0.0)]
    found = estimate_balance(recordings, model, rms_torque(recordings, model))
    assert found is not None and found.inertia == pytest.approx(INERTIA, rel=0.05)

"""A regression on a noisy acceleration gives too small an inertia, unless the noise is subtracted."""

import math
from dataclasses import replace

import numpy as np
import pytest

from ema_bench_replay.recording import Recording
from ema_twin_sim.identification import fit as fits
from ema_twin_sim.identification.equation import EquationErrorProblem
from ema_twin_sim.identification.fit import fit
from ema_twin_sim.identification.hypothesis import null_hypothesis
from ema_twin_sim.measured.observation import observe_all
from ema_twin_sim.measured.scales import to_own_units
from ema_twin_sim.model import load_model

PERIOD, SPEED_NOISE, CURRENT_NOISE = 1e-3, 0.3, 0.01  # s, rad/s, A
INERTIA = 1e-3  # kg m^2


def shaken(seed):
    """A motor that swings fast, its speed read with noise."""
    random = np.random.default_rng(seed)
    time = np.arange(8_000) * PERIOD
    rate = 2.0 * math.pi * (2.0 + 0.1 * seed)
    angle, speed = np.sin(rate * time), rate * np.cos(rate * time)
    torque = -INERTIA * rate**2 * np.sin(rate * time) + 0.01 * speed
    signals = {
        "current": torque + CURRENT_NOISE * random.standard_normal(len(time)),
        "speed": speed + SPEED_NOISE * random.standard_normal(len(time)),
        "motor_position": angle,
    }
    return Recording("shaken", np.arange(len(time)) * 1_000_000, signals, motor_angle_origin=0.0)


@pytest.fixture(scope="module")
def motor():
    model = load_model("laas_motor").with_value("machine.torque_constant", 1.0)
    model = model.with_value("sensors.current_noise", CURRENT_NOISE).with_value("sensors.sample_period", PERIOD)
    # a counter as coarse as that leaves the motion to the speed
    model = model.with_value("sensors.speed_noise", SPEED_NOISE).with_value("sensors.motor_encoder_counts", 60.0)
    model = model.with_effect("viscous_friction", {"coefficient": 0.02})
    return replace(model, effects={name: replace(held, open=True) for name, held in model.effects.items()})


def inertia_off(motor):
    """(mean relative error of the inertia over several runs, standard error of that mean)."""
    errors = []
    for seed in range(12):
        recordings, own = to_own_units([shaken(seed)], motor)
        found = fit(EquationErrorProblem(observe_all(list(recordings), own)), null_hypothesis(own))
        factor = found.hypothesis.by_path["scale.inertia"]
        total = sum(own.value(f"machine.{part}_inertia") for part in ("motor", "gearbox", "output"))
        errors.append(factor * total * own.units.factor("kg m^2") / INERTIA - 1.0)
    return float(np.mean(errors)), float(np.std(errors) / math.sqrt(len(errors)))


def test_an_inertia_is_not_too_small_by_the_noise(motor, monkeypatch):
    off, error = inertia_off(motor)
    assert abs(off) < 3.0 * error + 1e-3
    monkeypatch.setattr(fits.AccelerationNoise, "of", lambda *_: None)
    without, _ = inertia_off(motor)
    assert without < -3.0 * error - 1e-3

"""Machines of which no constant is known, whose dry friction turns round over a range of speeds, as in textbooks.

Simulators write it so, and lubricated joints behave so. Where the range is narrow, no law of friction is that exact,
and no correction of it is named; where it is wide, that is what the model lacks.
"""

import math

import numpy as np
import pytest

from ema_bench_replay.recording import Recording
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.discovery.slight_laws import REASON
from ema_twin_sim.effects import catalogue
from ema_twin_sim.model import load_model
from tests.opened import with_open_effects

PERIOD = 2e-3  # s
NOISE = 5e-3  # A
INERTIA, DRY, VISCOUS, TORQUE_CONSTANT = 6.5e-3, 0.3, 0.02, 0.67
FASTEST = 10.0  # rad/s


@pytest.fixture(scope="module")
def machine():
    model = load_model("laas_motor").with_effect("coulomb_friction", {"torque": 0.1})
    for path, value in (
        ("machine.torque_constant", TORQUE_CONSTANT),
        ("machine.motor_inertia", 1e-3),
        ("sensors.motor_encoder_counts", 1e6),
        ("sensors.current_noise", NOISE),
        ("sensors.sample_period", PERIOD),
    ):
        model = model.with_value(path, value)
    return with_open_effects(model)


def swung(law, beside=lambda angle, speed: 0.0, seed=1):
    """A recording of 30 s by counter and current; ``law`` gives the share of the dry level at a speed [rad/s]."""
    random = np.random.default_rng(seed)
    time = np.arange(15_000) * PERIOD
    rates, phases = random.uniform(0.4, 4.0, 5), random.uniform(0.0, 2.0 * math.pi, 5)
    waves = [np.sin(rate * time + phase) for rate, phase in zip(rates, phases, strict=True)]
    speed = FASTEST / np.max(np.abs(sum(waves))) * sum(waves)
    angle = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * PERIOD)])
    torque = INERTIA * np.gradient(speed, PERIOD) + DRY * law(speed) + VISCOUS * speed + beside(angle, speed)
    current = torque / TORQUE_CONSTANT + NOISE * random.standard_normal(len(time))
    signals = {"current": current, "motor_position": angle}
    return Recording(f"swing_{seed}", np.arange(len(time)) * 2_000_000, signals, motor_angle_origin=0.0)


def tanh(transition):
    return lambda speed: np.tanh(speed / transition)


def of_speed(found):
    return {id for id in found.added if catalogue()[id].depends_on == "speed"}


def test_a_narrow_transition_is_no_missing_effect(machine):
    found = discover([swung(tanh(2e-3 * FASTEST), seed=seed) for seed in (1, 2, 3)], machine)
    assert (found.verdict, found.added) == ("none", ())


@pytest.mark.slow
def test_a_wide_transition_is_named_with_its_speed(machine):
    found = discover([swung(tanh(0.05 * FASTEST), seed=seed) for seed in (1, 2, 3)], machine)
    assert (found.verdict, found.added) == ("explained", ("smooth_friction",))
    speed = found.parameters["smooth_friction"]["speed"]
    assert speed["value"] == pytest.approx(0.05 * FASTEST, rel=0.05)


@pytest.mark.slow
def test_a_load_is_named_alone_beside_a_law_that_no_effect_has(machine):
    """An arctangent's long tails look like a lubricant that thins, by less than a hundredth of the torque."""

    def law(speed):
        return 2.0 / math.pi * np.arctan(3.0 * speed / (5e-3 * FASTEST))

    def load(angle, speed):
        return 0.12 * np.sin(angle)

    found = discover([swung(law, load, seed=seed) for seed in (1, 2, 3)], machine)
    assert found.verdict == "explained"
    assert found.added in (("gravity_load",), ("cogging",))  # without a gear these are one
    gone = {name for turn in found.search.rounds if turn.reason == REASON for name in turn.removed}
    assert gone and not of_speed(found)

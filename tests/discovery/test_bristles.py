"""A bristle without damping is Dahl's model, and one with it LuGre's: both are named with their numbers."""

import numpy as np
import pytest

from ema_bench_replay.recording import Recording
from ema_twin_sim.discovery.discover import discover
from tests.large_arm import COULOMB, INERTIA, VISCOUS, open_arm

STIFFNESS = 400.0  # N m/rad, so that the bristle bends by 0.05 rad


def bent(speed, damping, period):
    """Torque (n,) [N m] of a bristle that is dragged at a ``speed`` (n,) [rad/s], by small steps of its equation."""
    bend, torque = 0.0, np.empty(len(speed))
    for k, v in enumerate(speed):
        bend_rate = v - STIFFNESS * abs(v) * bend / COULOMB
        torque[k] = STIFFNESS * bend + damping * bend_rate
        bend = (bend + v * period) / (1.0 + STIFFNESS * abs(v) * period / COULOMB)
    return torque


def dragged(model, damping):
    """Two runs of an arm without gravity whose friction bends, from rest."""
    random, period, found = np.random.default_rng(4), 1e-4, []
    fine = np.arange(200_000) * period
    for rate in (0.8, 2.0):
        angle, speed = 0.6 * np.cos(rate * fine), -0.6 * rate * np.sin(rate * fine)
        acceleration = -(rate**2) * angle
        torque = INERTIA * acceleration + VISCOUS * speed + bent(speed, damping, period)
        torque = torque[::20] + 0.3 * random.standard_normal(len(fine[::20]))
        signals = {
            "current": torque / model.value("machine.torque_constant"),
            "speed": speed[::20],
            "motor_position": angle[::20],
        }
        stamps = np.arange(len(torque)) * 2_000_000
        found.append(Recording(f"swing_{rate:g}", stamps, signals, motor_angle_origin=0.0, output_angle_origin=0.0))
    return found


@pytest.mark.slow
@pytest.mark.parametrize("damping", [0.0, 30.0])
def test_a_bristle_is_named_with_its_numbers_on_a_machine_of_which_nothing_is_known(damping):
    arm = open_arm().without_effect("gravity_load")
    found = discover(dragged(arm, damping), arm)
    assert (found.verdict, found.added) == ("explained", ("presliding_friction",))
    told = found.parameters["presliding_friction"]
    assert told["stiffness"]["value"] == pytest.approx(STIFFNESS, rel=0.05)
    assert told["damping"]["value"] == pytest.approx(damping, abs=5.0)
    assert not [text for text in found.warnings if "damping is on its bound" in text]

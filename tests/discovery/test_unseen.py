"""What is judged in motion: nothing of the torque that friction holds at standstill."""

import math

import numpy as np
import pytest

from ema_bench_replay.recording import Recording
from ema_twin_sim.criteria import NOISY
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.plant.counter import COUNTER_LAG
from tests.open_motor import open_motor

NOISE, PERIOD = 0.02, 0.002  # A, s
DRY, VISCOUS, INERTIA, TORQUE_CONSTANT = 12.0, 5.0, 2.0, 10.0
COGS, SIZE = 24, 3.0


def held_between_moves(cogs):
    """A joint that moves to and fro, and sticks in between by more than its friction in motion."""
    move, rest = np.arange(1000) * PERIOD, 600
    way = 2.0 * move - 2.0 * np.sin(math.pi * move) / math.pi
    there = np.r_[way, np.full(rest, way[-1])]
    angle = np.concatenate([there, way[-1] - there, there, way[-1] - there])
    speed = np.gradient(angle, PERIOD)
    torque = INERTIA * np.gradient(speed, PERIOD) + DRY * np.sign(speed) + VISCOUS * speed
    torque += cogs * np.sin(COGS * angle)
    still = speed == 0.0
    torque[still] = 1.5 * DRY * np.sign(np.sin(0.9 * np.arange(len(angle)) * PERIOD))[still]
    current = torque / TORQUE_CONSTANT + NOISE * np.random.default_rng(1).normal(size=len(angle))
    angle = angle + 1e-6 * np.random.default_rng(2).normal(size=len(angle))
    signals = {"current": current, "motor_position": angle}
    stamps = np.arange(len(angle)) * round(1e9 * PERIOD)
    return Recording("held", stamps, signals, motor_angle_origin=0.0)


@pytest.mark.parametrize(("cogs", "named"), [(0.0, ()), (SIZE, ("cogging",))])
def test_what_friction_holds_at_standstill_is_no_error_in_motion(cogs, named):
    """The filters of the unexplained torque carry it into the first moments of each move."""
    model = open_motor(TORQUE_CONSTANT, NOISE, PERIOD, coulomb=10.0, viscous=4.0)
    found = discover([held_between_moves(cogs)], model)
    assert found.added == named
    of_noise = TORQUE_CONSTANT * NOISE * math.sqrt(PERIOD / (4.0 * COUNTER_LAG))  # what two equal lags pass of it
    assert found.unseen.rmse[-1] > 2.0 * NOISY * of_noise
    assert found.unseen.settled[-1] < NOISY * of_noise

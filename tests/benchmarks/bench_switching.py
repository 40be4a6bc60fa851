"""The switching step beside the same equations in C, in one run: ratios, since machines differ and are noisy."""

import ctypes
import math

import numpy as np
import pytest
from numba import njit

from ema_twin_sim.plant.switching.electrical_angle import sine_and_cosine, turned
from ema_twin_sim.plant.switching.step import switching_step
from ema_twin_sim.plant.switching.step_constants import step_constants
from tests.benchmarks.in_c import c_loop, pointer
from tests.benchmarks.timing import fastest
from tests.turned_motor import STEP, winding

ROUNDS = 100
CYCLE = 125  # steps of 1 us in a control cycle
SETPOINT = 2.0  # A
SPEED = 5.0  # rad/s
MOTORS = {
    "sinusoidal": {},
    "trapezoidal": {"trapezoidal": 1.0},
    "all faults": {
        "active_turns_u": 0.9, "active_turns_w": 0.8, "eccentricity": 0.1, "eccentricity_phase": 0.4,
        "resolver_amplitude": 0.01, "resolver_order": 2.0, "resolver_offset": 0.02, "magnet_strength": 0.95,
        "torque_limit": 3.5,
    },
}  # fmt: skip


@njit(error_model="numpy")
def advance(windings, steps, cycle, step, setpoint, speed):
    """As ``advance`` of switching.c."""
    constants = step_constants(windings[0], step)
    turns = constants.pole_pairs / (2.0 * math.pi)
    current_u = current_v = current_w = quadrature = direct = voltage = 0.0
    leg_u = leg_v = leg_w = -1.0
    angle = torques = air_gap_torques = energy = lost = 0.0
    sine, cosine = 0.0, 1.0
    left = 0
    for _ in range(steps):
        middle = angle + 0.5 * step * speed
        if left == 0:
            left = cycle
            sine, cosine = sine_and_cosine(turns * middle)
        else:
            sine, cosine = turned(sine, cosine, constants.pole_pairs * step * speed)
        left -= 1
        (
            current_u, current_v, current_w, leg_u, leg_v, leg_w, quadrature, direct, voltage,
            torque, air_gap_torque, power, loss,
        ) = switching_step(
            constants, current_u, current_v, leg_u, leg_v, leg_w, quadrature, direct, voltage,
            setpoint, middle, sine, cosine, speed,
        )  # fmt: skip
        torques += torque
        air_gap_torques += air_gap_torque
        energy += power * step
        lost += loss * step
        angle += step * speed
    return (
        current_u, current_v, current_w, leg_u, leg_v, leg_w, quadrature, direct, voltage,
        angle, torques / steps, air_gap_torques / steps, energy, lost,
    )  # fmt: skip


@pytest.fixture(scope="module")
def in_c(tmp_path_factory):
    return c_loop("switching", tmp_path_factory.mktemp("c"))


def by_c(function, motor, steps):
    begun = np.zeros(14)  # as switching.c's state_t
    begun[3:6] = -1.0  # all lower switches closed
    numbers = [ctypes.c_double(value) for value in (STEP, SETPOINT, SPEED)]

    def call():
        state = begun.copy()
        function(pointer(motor), pointer(state), ctypes.c_long(steps), ctypes.c_long(CYCLE), *numbers)
        return state

    return call


@pytest.mark.parametrize("motor", MOTORS)
def test_speed_of_the_switching_step(motor, in_c, say):
    record = winding(**MOTORS[motor])
    steps = 20_000
    results = advance(record, steps, CYCLE, STEP, SETPOINT, SPEED)
    np.testing.assert_allclose(by_c(in_c, record, steps)(), results, rtol=1e-9, atol=1e-9)

    calls = (lambda: advance(record, steps, CYCLE, STEP, SETPOINT, SPEED), by_c(in_c, record, steps))
    ours, theirs = (1e9 * seconds / steps for seconds in fastest(ROUNDS, *calls))
    say(f"\n  switching step, {motor:<14}{ours:>8.1f} ns{theirs:>8.1f} ns in C{ours / theirs:>8.2f} x C")
    assert ours <= 1.5 * theirs

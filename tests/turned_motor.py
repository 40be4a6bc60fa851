"""The switching drive's electrical side under an imposed motion and setpoint, every step of it written down."""

import math

import numpy as np
from numba import njit

from ema_twin_sim.plant.switching.electrical_angle import sine_and_cosine
from ema_twin_sim.plant.switching.layout import WINDING, WINDING_STATE, resting
from ema_twin_sim.plant.switching.step import switching_step
from ema_twin_sim.plant.switching.step_constants import step_constants

STEP = 1e-6  # s
POLITECNICO = {
    "pole_pairs": 4.0,
    "phase_resistance": 1.375,
    "phase_inductance": 15.25e-3,
    "back_emf_constant": 0.955,
    "torque_constant": 1.91,
    "torque_limit": math.inf,
    "magnet_strength": 1.0,
    "active_turns_u": 1.0,
    "active_turns_v": 1.0,
    "active_turns_w": 1.0,
    "dc_link_voltage": 380.0,
    "hysteresis": 0.1,
    "switch_resistance": 0.01,
    "current_filter": 5e-4,
}
COLUMNS = (*WINDING_STATE.names, "torque", "air_gap_torque", "power", "loss", "angle")


def winding(**changes):
    """Record (1,) of the thesis's motor and bridge, all that is not named healthy and ideal."""
    record = np.zeros(1, WINDING)
    for name, value in (POLITECNICO | changes).items():
        record[name] = value
    return record


@njit(error_model="numpy", cache=True)  # kept in a folder named after all of the plant's sources
def _turn(windings, states, rows, setpoint, angle, speed, step):
    constants = step_constants(windings[0], step)
    state = states[0]
    current_u, current_v, current_w = state.phase_current_u, state.phase_current_v, state.phase_current_w
    leg_u, leg_v, leg_w = state.leg_u, state.leg_v, state.leg_w
    quadrature, direct, voltage = state.quadrature_current, state.direct_current, state.quadrature_voltage
    for k in range(rows.shape[0]):
        middle = angle + (k + 0.5) * step * speed
        sine, cosine = sine_and_cosine(constants.pole_pairs / (2.0 * math.pi) * middle)
        (
            current_u,
            current_v,
            current_w,
            leg_u,
            leg_v,
            leg_w,
            quadrature,
            direct,
            voltage,
            torque,
            air_gap_torque,
            power,
            loss,
        ) = switching_step(
            constants, current_u, current_v, leg_u, leg_v, leg_w, quadrature, direct, voltage, setpoint, middle, sine,
            cosine, speed,
        )  # fmt: skip
        row = rows[k]
        row[0], row[1], row[2] = current_u, current_v, current_w
        row[3], row[4], row[5] = leg_u, leg_v, leg_w
        row[6], row[7], row[8] = quadrature, direct, voltage
        row[9], row[10], row[11], row[12], row[13] = torque, air_gap_torque, power, loss, middle
    state.phase_current_u, state.phase_current_v, state.phase_current_w = current_u, current_v, current_w
    state.leg_u, state.leg_v, state.leg_w = leg_u, leg_v, leg_w
    state.quadrature_current, state.direct_current, state.quadrature_voltage = quadrature, direct, voltage


def turn(windings, seconds, setpoint, speed, angle=0.0, step=STEP, state=None, settle=0.0):
    """Columns (n,) by name of a run at constant speed [rad/s] and setpoint [A], after ``settle`` [s] not written down.

    Currents, legs and filters are those after each step, torques and powers its means, ``angle`` that of its middle.
    """
    state = resting() if state is None else state
    waiting = round(settle / step)
    rows = np.empty((waiting + round(seconds / step), len(COLUMNS)))
    _turn(windings, state, rows, float(setpoint), float(angle), float(speed), step)
    return {name: rows[waiting:, k] for k, name in enumerate(COLUMNS)}


def turns(windings, count, setpoint, speed, **others):
    """``turn`` over a whole number of the motor's turns."""
    return turn(windings, count * 2.0 * math.pi / speed, setpoint, speed, **others)


def order(run, name, cycles):
    """Complex amplitude of a signal at an order [cycles a turn of the motor], cos(order x angle) being real."""
    return 2.0 * np.mean(run[name] * np.exp(-1j * cycles * run["angle"]))


def currents(run):
    """Phase currents (n, 3) [A]."""
    return np.stack([run[f"phase_current_{phase}"] for phase in "uvw"], axis=1)

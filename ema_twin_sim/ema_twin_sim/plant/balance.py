"""The unexplained torque: what the measured motion needs and the model does not account for.

At each sample the model's torques are taken at the *measured* operating point and compared with the measured
acceleration. Positive values oppose positive motion, as every torque of the catalogue does:

    unexplained = F[ Kt i - friction - effects ] - J F[ dw/dt ]

F is one causal filter for both sides: the drive's own smoothing of the speed (which the measured speed already has, so
it is applied to the torques only) and two equal lags that keep the derivative of a noisy speed readable. Being causal,
it is computed sample by sample in the same way live and offline. Where the transmission has play or gives way, the
output side is simulated, driven by the measured motor (``driven_output.py``).
"""

import math

import numpy as np
from numba import njit

from .drive import lag_gain
from .driven_output import driven_output
from .evaluate import evaluate
from .friction import bristle_step, directed, held_by_dry_friction
from .layout import CURRENT_IN, MOTOR_POSITION_IN, SPEED_IN, STATE
from .operating_point import OperatingPoint

BALANCE_LAG = 0.005  # s, each of the two lags: together about 20 Hz, above what friction and loads vary with
COUNTER_LAG = 0.020  # s, where the speed is a counter's difference (0.08 rad/s of quantisation at 2 ms)
STANDSTILL = 0.05  # rad/s of the fast shaft, below which the shaft counts as held by dry friction


@njit(error_model="numpy")
def unsmoothed(speed, before, interval, smoothing):
    """True speed [rad/s] from two samples of a speed smoothed by a first-order lag."""
    return speed + smoothing * (speed - before) / interval


@njit(error_model="numpy")
def unbalanced_torque(drive_torque, other_torque, speed, viscous, dry, break_away):
    """Torque [N m] that the model leaves to accelerate the measured motion, before filtering."""
    torque = drive_torque - other_torque - viscous * speed
    if math.fabs(speed) < STANDSTILL:
        return held_by_dry_friction(torque, break_away)
    return torque - math.copysign(dry, speed)


@njit(error_model="numpy")
def filtered_balance(state, torque, speed, inertia, interval, smoothing, lag):
    """Unexplained torque [N m] after one more sample; ``state`` carries the filters (``balance_*``)."""
    if state.balance_ready == 0.0:
        # the filters start as if the motion before the first sample had been steady
        state.balance_torque_1 = torque
        state.balance_torque_2 = torque
        state.balance_torque_3 = torque
        state.balance_speed_1 = speed
        state.balance_speed_2 = speed
        state.balance_ready = 1.0
        return torque
    gain = lag_gain(interval, lag)
    state.balance_torque_1 += lag_gain(interval, smoothing) * (torque - state.balance_torque_1)
    state.balance_torque_2 += gain * (state.balance_torque_1 - state.balance_torque_2)
    state.balance_torque_3 += gain * (state.balance_torque_2 - state.balance_torque_3)
    before = state.balance_speed_2
    state.balance_speed_1 += gain * (speed - state.balance_speed_1)
    state.balance_speed_2 += gain * (state.balance_speed_1 - state.balance_speed_2)
    return state.balance_torque_3 - inertia * (state.balance_speed_2 - before) / interval


@njit(error_model="numpy")
def unexplained_torque(plant, state, effects, bench, row, interval, time, step):
    """The unexplained torque [N m] at one sample (see the module), NaN where current or motion is not measured."""
    current = bench[row, CURRENT_IN]
    position = bench[row, MOTOR_POSITION_IN]
    counter_speed = (position - bench[row - 1, MOTOR_POSITION_IN]) / interval
    smoothing = plant.speed_smoothing
    lag = BALANCE_LAG
    speed = bench[row, SPEED_IN]
    if math.isnan(speed):
        # a difference over one interval is the speed half an interval ago
        speed = counter_speed
        smoothing = 0.5 * interval
        lag = COUNTER_LAG
        sharp = state.balance_speed_1 if state.balance_ready != 0.0 else speed
    else:
        sharp = unsmoothed(speed, bench[row - 1, SPEED_IN], interval, smoothing)
    if math.isnan(current) or math.isnan(speed):
        return math.nan
    ratio = plant.gear_ratio
    inertia = plant.motor_inertia + plant.output_inertia
    acceleration = (speed - state.balance_speed_1) / lag if state.balance_ready != 0.0 else 0.0
    drive_torque = plant.torque_constant * current
    travel = 0.0 if math.isnan(position) else position
    at = OperatingPoint(
        time,
        state.motor_angle_origin + travel,
        sharp,
        state.output_angle_origin + travel / ratio,
        travel / ratio,
        sharp / ratio,
        acceleration,
        current,
        drive_torque,
        plant.output_inertia * acceleration + plant.output_viscous * sharp + math.copysign(plant.output_dry, sharp),
        plant.motor_dry + plant.output_dry,
        plant.motor_viscous + plant.output_viscous,
    )
    torque, dry, output_torque = evaluate(effects, at)
    viscous = plant.motor_viscous + plant.output_viscous
    break_away = plant.motor_break_away + plant.output_break_away + (dry - plant.motor_dry - plant.output_dry)
    if plant.two_inertia == 0.0:
        other = torque + output_torque
    else:
        passed = driven_output(plant, state, sharp, travel, output_torque, interval, step)
        other = torque + passed
        viscous = plant.motor_viscous
        inertia = plant.motor_inertia
        dry -= plant.output_dry
        break_away -= plant.output_break_away
    if plant.asymmetry != 0.0:
        factor = directed(plant.asymmetry, sharp, drive_torque - other)
        other += plant.asymmetry * viscous * math.fabs(sharp)
        dry *= factor
        break_away *= factor
    if plant.bristle_stiffness > 0.0:
        state.driven_bristle, bent = bristle_step(
            state.driven_bristle, sharp, dry, plant.bristle_stiffness, plant.bristle_damping, interval
        )
        other += bent
        dry = break_away = 0.0
    unbalanced = unbalanced_torque(drive_torque, other, sharp, viscous, dry, break_away)
    return filtered_balance(state, unbalanced, speed, inertia, interval, smoothing, lag)


@njit(cache=True, error_model="numpy")
def balance_response(plants, interval, has_speed, of_current, count):
    """Unexplained torque [N m] (count,) that one sample's error of 1 A, or of 1 rad/s (1 rad), causes while turning.

    Friction enters by its viscous part alone: away from standstill the dry level does not see the noise.
    """
    plant = plants[0]
    state = np.zeros(1, STATE)[0]
    response = np.zeros(count)
    viscous = plant.motor_viscous + plant.output_viscous
    inertia = plant.motor_inertia + plant.output_inertia
    before = 0.0
    for k in range(count):
        hit = 1.0 if k == 1 else 0.0
        current = hit if of_current else 0.0
        motion = 0.0 if of_current else hit
        if has_speed:
            speed = motion
            sharp = unsmoothed(speed, before, interval, plant.speed_smoothing)
            smoothing, lag = plant.speed_smoothing, BALANCE_LAG
        else:
            speed = (motion - before) / interval
            sharp = state.balance_speed_1
            smoothing, lag = 0.5 * interval, COUNTER_LAG
        torque = plant.torque_constant * current - viscous * sharp
        response[k] = filtered_balance(state, torque, speed, inertia, interval, smoothing, lag)
        before = motion
    return response

"""The unexplained torque: needed by the measured motion and not accounted for by the model.

At each sample the model's torques are evaluated at the *measured* operating point and compared with the measured
acceleration. Positive values oppose positive motion, as every torque of the catalogue does:

    unexplained = F[ Kt i - friction - effects ] - J F[ dw/dt ]

F is one causal filter for both sides, computed sample by sample in the same way live and offline: the drive's own
smoothing of the speed (applied to the torques only, since the measured speed already has it) and two equal lags that
keep the derivative of a noisy speed usable. Both sides are evaluated at the middle of the interval: a shift of half a
sample would appear as inertia times jerk. If no speed is measured, the motor counter's difference is used; it is so
coarse (0.08 rad/s at 2 ms) that the first lag is applied before the model's torques are evaluated. What follows from
that speed has then passed the lag; what follows from position, current and measured load passes it afterwards, as if
these alone had changed in each interval (``late``). Dry friction of the motor's side follows the direction in which the
counter moves, and that direction passes the lag (``counter_direction``): the lagged speed turns round later than the
shaft. If the transmission has backlash or compliance, the output is simulated, driven by the measured motor
(``driven_output.py``).
"""

import math

import numpy as np
from numba import njit

from .counter import COUNTER_LAG, TURNED, counter_at_rest, counter_direction, counter_speed, counter_torque, late
from .drive import lag_gain
from .driven_output import driven_output
from .evaluate import evaluate
from .friction import bristle_share, held_by_dry_friction, rubbing
from .layout import CURRENT_IN, LOAD_IN, MOTOR_POSITION_IN, OUT, SPEED_IN
from .operating_point import OperatingPoint, changed
from .transmission import end_stop_torque

BALANCE_LAG = 0.005  # s, each of the two lags: together about 20 Hz, above the variation of friction and loads
SETTLED = 6.0
"""Lags until the filters have forgotten that nothing is known of the motion before the first sample: 2 % is left."""
STANDSTILL = 1.0 / 160.0
"""Share of sqrt(dry friction / inertia) [rad/s] below which the shaft counts as held by dry friction.

That friction stops a shaft of this speed within a radian. On the Torino bench, where the share was set, it is 8 rad/s.
"""
MOST_STANDSTILL = 0.05
"""rad/s, its limit: the inertia of a draft may be guessed far too small, and every motion would count as standstill."""


@njit(error_model="numpy")
def unsmoothed(speed, before, interval, smoothing):
    """Unsmoothed speed [rad/s] from two samples of a speed smoothed by a first-order lag."""
    return speed + smoothing * (speed - before) / interval


@njit(error_model="numpy")
def lagged_line(value, input_before, input_now, interval, time_constant):
    """Exact output of a first-order lag after an interval in which its input changed linearly."""
    if time_constant <= 0.0:
        return input_now
    slope = (input_now - input_before) * (time_constant / interval)
    return input_now - slope + (value - input_before + slope) * math.exp(-interval / time_constant)


@njit(error_model="numpy")
def lagged_acceleration(state, speed, interval, has_speed):
    """Acceleration [rad/s²] after the first lag, which the ``speed`` has not passed yet: the lagged speed's rise.

    Right at any interval: a lag's exact gain over a long one is far from interval over time constant.
    """
    if state.balance_ready == 0.0:
        return 0.0
    gain = lag_gain(interval, BALANCE_LAG if has_speed else COUNTER_LAG)
    return gain * (speed - state.balance_speed_1) / interval


@njit(error_model="numpy")
def filtered_balance(state, torque, speed, inertia, interval, has_speed, smoothing):
    """Unexplained torque [N m] after one more sample; ``state`` carries the filters (``balance_*``).

    ``speed`` [rad/s] is the measured one; a counter's speed and its torque have already passed their first lag.
    """
    if state.balance_ready == 0.0:
        # the filters assume steady motion before the first sample
        if has_speed:
            state.balance_torque_in = torque
            state.balance_torque_1 = torque
            state.balance_speed_1 = speed
        state.balance_torque_2 = torque
        state.balance_torque_3 = torque
        state.balance_speed_2 = state.balance_speed_1
        state.balance_torque_late = 0.0
        state.balance_dry_late = 0.0
        state.balance_ready = 1.0
        return torque
    torque_before = state.balance_torque_3
    speed_before = state.balance_speed_2
    if has_speed:
        gain = lag_gain(interval, BALANCE_LAG)
        state.balance_torque_1 = lagged_line(
            state.balance_torque_1, state.balance_torque_in, torque, interval, smoothing
        )
        state.balance_torque_in = torque
        state.balance_torque_2 += gain * (state.balance_torque_1 - state.balance_torque_2)
        state.balance_torque_3 += gain * (state.balance_torque_2 - state.balance_torque_3)
        state.balance_speed_1 += gain * (speed - state.balance_speed_1)
    else:
        gain = lag_gain(interval, COUNTER_LAG)
        state.balance_torque_3 += gain * (torque - state.balance_torque_3)
    state.balance_speed_2 += gain * (state.balance_speed_1 - state.balance_speed_2)
    acceleration = (state.balance_speed_2 - speed_before) / interval
    return 0.5 * (state.balance_torque_3 + torque_before) - inertia * acceleration


@njit(error_model="numpy")
def _point(plant, state, time, travel, current, speed, acceleration, transmitted):
    """The measured operating point at which effects act."""
    ratio = plant.gear_ratio
    angle = state.motor_angle_origin + travel
    return OperatingPoint(
        time,
        angle,
        plant.pole_pairs * angle,
        speed,
        state.output_angle_origin + (travel + state.output_start) / ratio,
        travel / ratio,
        speed / ratio,
        acceleration,
        current,
        plant.torque_constant * current,
        transmitted,
        plant.motor_dry + (plant.output_dry if plant.two_inertia == 0.0 else 0.0),
        plant.motor_viscous + plant.output_viscous,
    )


@njit(error_model="numpy")
def _stopped(plant, state, travel, speed):
    """Torque [N m] of the end stops at the motor's ``travel`` [rad]."""
    if math.isinf(plant.end_stop_lower) and math.isinf(plant.end_stop_upper):
        return 0.0
    ratio = plant.gear_ratio
    stop = state.output_angle_origin * ratio + state.output_start
    lower, upper = plant.end_stop_lower * ratio - stop, plant.end_stop_upper * ratio - stop
    return end_stop_torque(travel, speed, lower, upper, plant.contact_stiffness, plant.contact_damping)


@njit(error_model="numpy")
def _unexplained(plant, state, effects, before, now, simulated_angle, interval, time, step):
    """The unexplained torque [N m] at the bench's sample ``now`` (see the module).

    NaN without current or motion, and until the filters have settled. ``simulated_angle`` [rad] replaces an unmeasured
    motor position. After a sample without a value the filters start again.
    """
    position = now[MOTOR_POSITION_IN]
    speed = now[SPEED_IN]
    speed_before = before[SPEED_IN]
    has_speed = not (math.isnan(speed) and math.isnan(speed_before))
    if not has_speed:
        speed = (position - before[MOTOR_POSITION_IN]) / interval
        speed_before = speed
    if math.isnan(now[CURRENT_IN]) or math.isnan(speed) or math.isnan(speed_before):
        state.balance_ready = 0.0
        state.driven_ready = 0.0
        return math.nan
    smoothing = plant.speed_smoothing
    current = now[CURRENT_IN]
    acceleration = lagged_acceleration(state, speed, interval, has_speed)
    sharp = unsmoothed(speed, speed_before, interval, smoothing) if has_speed else counter_speed(state, speed, interval)
    travel = simulated_angle if math.isnan(position) else position
    dither = plant.motor_dither
    sense = 1.0 if sharp > 0.0 else -1.0
    if not has_speed:
        sense = counter_direction(state, position, dither, interval)
    own = plant.output_inertia * acceleration + plant.output_viscous * sharp + plant.output_dry * sense
    at = _point(plant, state, time, travel, current, sharp, acceleration, own)
    torque, dry, load, thinned = evaluate(effects, at)
    load += now[LOAD_IN] + _stopped(plant, state, travel, sharp)
    total_dry = plant.motor_dry + plant.output_dry
    rigid = plant.two_inertia == 0.0
    transmitted = own + load if rigid else driven_output(plant, state, sharp, travel, load, interval, step)
    if transmitted != own:
        # the load determines the transmitted torque, and effects that depend on it are evaluated afterwards
        torque, dry, _, thinned = evaluate(effects, changed(at, transmitted, at.dry_level))
    driving = plant.torque_constant * current
    if not has_speed:
        driving = counter_torque(state, driving, interval)
        # the same torques at this speed before position, current and measured load changed
        past = before[MOTOR_POSITION_IN]
        earlier = _point(plant, state, time - interval, past, before[CURRENT_IN], sharp, acceleration, transmitted)
        torque_before, dry_before, load_before, _ = evaluate(effects, earlier)
        if rigid:
            load_before += before[LOAD_IN] + _stopped(plant, state, past, sharp)
            if load_before != load:  # friction of the teeth follows it
                loaded = changed(earlier, own + load_before, earlier.dry_level)
                torque_before, dry_before, _, _ = evaluate(effects, loaded)
            torque_before += load_before
        change = torque + (load if rigid else 0.0) - torque_before
        if state.balance_ready != 0.0:
            state.balance_torque_late = late(state.balance_torque_late, change, interval)
            state.balance_dry_late = late(state.balance_dry_late, dry - dry_before, interval)
            torque += state.balance_torque_late
            dry += state.balance_dry_late
    if rigid:
        torque += load
        passed = 0.0
        viscous = plant.motor_viscous + plant.output_viscous
        inertia = plant.motor_inertia + plant.output_inertia
        base_dry = total_dry
        break_away = plant.motor_break_away + plant.output_break_away
    else:
        passed = transmitted
        viscous = plant.motor_viscous
        inertia = plant.motor_inertia
        base_dry = plant.motor_dry
        break_away = plant.motor_break_away
    dry = max(0.0, dry)
    break_away = max(0.0, break_away + dry - base_dry)
    driving -= torque
    share = 1.0 if rigid else bristle_share(plant)
    bristled = plant.bristle_stiffness > 0.0
    sliding = 0.0 if bristled else dry * (sense + plant.asymmetry)
    uneven, bent, dry, break_away, state.driven_bristle = rubbing(
        sharp, driving - passed, plant.asymmetry, viscous + thinned, dry, break_away, bristled, state.driven_bristle,
        plant.bristle_stiffness * share, plant.bristle_damping * share, interval,
    )  # fmt: skip
    unbalanced = driving - passed - uneven - bent - viscous * sharp
    standstill = min(STANDSTILL * math.sqrt(total_dry / (plant.motor_inertia + plant.output_inertia)), MOST_STANDSTILL)
    # a shaft that turns round at speed is not held, though its lagged speed passes through zero
    reverses = not has_speed and math.fabs(speed) > standstill + TURNED * dither / interval
    if math.fabs(sharp) < standstill and not reverses:
        if not has_speed:
            counter_at_rest(state, position, unbalanced, dry)
        unbalanced = held_by_dry_friction(unbalanced, break_away)
    else:
        unbalanced -= sliding
    unexplained = filtered_balance(state, unbalanced, speed, inertia, interval, has_speed, smoothing)
    return math.nan if time < SETTLED * (BALANCE_LAG if has_speed else COUNTER_LAG) else unexplained


@njit(error_model="numpy")
def estimate(plant, state, effects, time, stamps, bench, twin, step):
    """Fill the unexplained torque in rows 1… of ``twin`` (n, signals), after the kernel has filled the other signals.

    ``stamps`` [ns] (n,), ``bench`` (n, 6), the ``state`` that carries the filters and the ``step`` [s] are the
    kernel's, ``effects`` all effects used to balance torques, ``time`` [s] that of row 0.
    """
    for row in range(1, stamps.shape[0]):
        interval = (stamps[row] - stamps[row - 1]) * 1e-9
        time += interval
        twin[row, OUT.unexplained_torque] = _unexplained(
            plant, state, effects, bench[row - 1], bench[row], twin[row, OUT.motor_position], interval, time, step
        )


@njit(cache=True, error_model="numpy")
def balance_response(plants, states, interval, has_speed, of_current, count):
    """Response of the unexplained torque [N m] (count,) to an error of 1 A, or 1 rad/s (1 rad), in one sample.

    For a turning shaft: only viscous friction enters, since away from standstill the dry level does not depend on
    noise. ``states`` (1,) are the filters at rest, which change. They are the caller's: an array made here would be
    freed after its last use, and its record would be read from memory that is used for something else.
    """
    plant, state = plants[0], states[0]
    response = np.zeros(count)
    viscous = plant.motor_viscous + plant.output_viscous
    inertia = plant.motor_inertia + plant.output_inertia
    before = 0.0
    for k in range(count):
        hit = 1.0 if k == 1 else 0.0
        motion = 0.0 if of_current else hit
        speed = motion if has_speed else (motion - before) / interval
        torque = plant.torque_constant * hit if of_current else 0.0
        if has_speed:
            sharp = unsmoothed(speed, before, interval, plant.speed_smoothing)
        else:
            sharp = counter_speed(state, speed, interval)
            torque = counter_torque(state, torque, interval)
        torque -= viscous * sharp
        response[k] = filtered_balance(state, torque, speed, inertia, interval, has_speed, plant.speed_smoothing)
        before = motion
    return response

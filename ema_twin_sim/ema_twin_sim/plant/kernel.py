"""The compiled step of the twin: one loop for a whole recording, for one live sample, and for the virtual bench.

``advance`` integrates from each row's stamp to the next with the input interpolated between both, in equal steps of at
most ``step`` seconds, and writes what the bench's sensors would show at each stamp. A live twin calls it with two rows,
an offline run with all of them: the arithmetic is the same, so are the results.
"""

import math

from numba import boolean, float64, from_dtype, int64, njit, types, void

from .balance import unexplained_torque
from .drive import lag_gain, limited, quadrature_voltage, speed_controller
from .evaluate import evaluate
from .friction import bristle_share, bristle_step, directed
from .layout import (
    BENCH,
    COMMAND_IN,
    CURRENT,
    CURRENT_IN,
    PLANT,
    SETPOINT,
    SETPOINT_IN,
    STANDALONE_SPEED,
    STATE,
)
from .operating_point import PARAMETER_SLOTS, OperatingPoint
from .sensors import counted, remember, shown
from .transmission import contact_torque, end_stop_torque, response, shaft_speed

_PLANT = from_dtype(PLANT)
_STATE = from_dtype(STATE)
_STAMPS = types.Array(int64, 1, "C", readonly=True)
_EFFECTS = types.Tuple((int64[::1], int64[::1], float64[:, ::1]))
"""Addresses (n,), places (n,), parameters (n, 4) of the effects that depend on the operating point."""

assert PARAMETER_SLOTS == 4 and len(BENCH) == 5  # the calls and columns below are written out


@njit(
    void(_PLANT[::1], _STATE[::1], _EFFECTS, int64, _STAMPS, float64[:, ::1], float64[:, ::1], float64, boolean),
    cache=True,
    nogil=True,
    error_model="numpy",
)
def advance(plants, states, effects, source, stamps, bench, twin, step, record):
    """Integrate over ``stamps`` [ns] (n,) and fill rows 1… of ``twin`` (n, signals); row 0 is the state's own.

    ``bench`` (n, 5) holds the columns ``layout.BENCH``, NaN where the machine lacks one; ``source`` is one of
    ``layout.INPUTS``. ``record`` false integrates without writing (to time the equations alone).
    """
    plant = plants[0]
    state = states[0]
    ratio = plant.gear_ratio
    per_ratio = 1.0 / ratio
    rigid = plant.two_inertia == 0.0
    stops = not (math.isinf(plant.end_stop_lower) and math.isinf(plant.end_stop_upper))
    # end stops stand where the encoder's own angle says, whatever a recording starts with
    stop_lower = (plant.end_stop_lower - state.output_angle_origin) * ratio
    stop_upper = (plant.end_stop_upper - state.output_angle_origin) * ratio
    # effects are opaque calls, across which no compiler keeps what it has read from memory: hence local copies
    stiffness = plant.contact_stiffness
    damping = plant.contact_damping
    gap = plant.gap
    softness = 1.0 / plant.motor_inertia + 1.0 / plant.output_inertia
    output_inertia = plant.output_inertia
    output_viscous = plant.output_viscous
    output_dry = plant.output_dry
    output_break_away = plant.output_break_away
    torque_constant = plant.torque_constant
    viscous_total = plant.motor_viscous + plant.output_viscous
    # what the motor's shaft carries itself: everything where the transmission is rigid
    inertia = plant.motor_inertia + (plant.output_inertia if rigid else 0.0)
    viscous = plant.motor_viscous + (plant.output_viscous if rigid else 0.0)
    base_dry = plant.motor_dry + (plant.output_dry if rigid else 0.0)
    base_break_away = plant.motor_break_away + (plant.output_break_away if rigid else 0.0)
    asymmetry = plant.asymmetry
    bristled = plant.bristle_stiffness > 0.0
    motor_share = 1.0 if rigid else bristle_share(plant)
    # effects see the model's whole dry level; what they change of it is the motor side's
    total_dry = plant.motor_dry + plant.output_dry
    elsewhere = total_dry - base_dry
    acting = effects[0].shape[0] > 0
    torque = output_torque = thinned = 0.0
    dry = base_dry
    break_away = base_break_away

    time = state.time
    angle = state.motor_angle
    speed = state.motor_speed
    output_angle = state.output_angle
    output_speed = state.output_speed
    current = state.current
    current_setpoint = state.current_setpoint
    integral = state.integral
    setpoint = state.speed_setpoint
    smoothed = state.smoothed_speed
    phase = state.control_phase
    bristle = state.bristle
    output_bristle = state.output_bristle
    acceleration = state.acceleration
    transmitted = state.transmitted_torque
    motor_origin = state.motor_angle_origin
    output_origin = state.output_angle_origin
    twist = state.twist

    column = (
        CURRENT_IN if source == CURRENT else (SETPOINT_IN if source in (SETPOINT, STANDALONE_SPEED) else COMMAND_IN)
    )
    step = plant.control_cycle / math.ceil(plant.control_cycle / step - 1e-9)  # so that cycles begin on a step
    h = per_step = 0.0
    interval_before = int64(-1)
    current_gain = setpoint_gain = smoothing_gain = 0.0
    motor_gain = motor_drag = output_gain = output_drag = 0.0
    steps = 1

    for row in range(1, stamps.shape[0]):
        nanoseconds = stamps[row] - stamps[row - 1]
        interval = nanoseconds * 1e-9
        if nanoseconds != interval_before:
            interval_before = nanoseconds
            steps = max(1, math.ceil(interval / step - 1e-9))
            h = interval / steps
            per_step = 1.0 / h
            motor_gain, motor_drag = response(h, inertia, viscous)
            output_gain, output_drag = response(h, plant.output_inertia, plant.output_viscous)
            current_gain = lag_gain(h, plant.current_lag)
            smoothing_gain = lag_gain(h, plant.speed_smoothing)
            setpoint_gain = lag_gain(plant.control_cycle, plant.speed_setpoint_filter)
        start = bench[row - 1, column]
        slope = bench[row, column] - start
        current_rate = 0.0

        for k in range(steps):
            # drive
            if source == CURRENT:
                given = start + slope * ((k + 0.5) / steps)
                current_rate = (given - current) * per_step
                current = given
                if phase >= plant.control_cycle - 0.5 * h:
                    phase -= plant.control_cycle
                    remember(state, output_angle)
            else:
                if phase >= plant.control_cycle - 0.5 * h:
                    phase -= plant.control_cycle
                    remember(state, output_angle)
                    given = start + slope * (k / steps)
                    integrate = True
                    if source == SETPOINT:
                        # a trace is sampled before its stamp's cycle runs: it shows a cycle's setpoint one cycle later
                        setpoint = given + slope * (plant.control_cycle / interval)
                    elif source == STANDALONE_SPEED:
                        setpoint += setpoint_gain * (limited(given, plant.speed_limit) - setpoint)
                    else:
                        error = given - shown(plant, state, output_angle, phase)
                        integrate = math.fabs(error) * ratio > plant.integral_dead_band
                        wanted = limited(plant.position_gain * error, plant.speed_limit)
                        setpoint += setpoint_gain * (wanted - setpoint)
                    demand, integral = speed_controller(plant, setpoint - speed, integral, integrate)
                    current_setpoint = demand / plant.nominal_torque_constant
                change = current_gain * (current_setpoint - current)
                current_rate = change * per_step
                current += change
            phase += h
            drive_torque = torque_constant * current

            # mechanics: half the drift, then the kick at the middle of the step
            angle += 0.5 * h * speed
            if not rigid:
                output_angle += 0.5 * h * output_speed
            else:
                output_angle = angle - twist
                output_speed = speed
            if acting:
                at = OperatingPoint(
                    time + k * h,
                    motor_origin + angle,
                    speed,
                    output_origin + output_angle * per_ratio,
                    output_angle * per_ratio,
                    output_speed * per_ratio,
                    acceleration,
                    current,
                    drive_torque,
                    transmitted,
                    total_dry,
                    viscous_total,
                )
                torque, dry, output_torque, thinned = evaluate(effects, at)
                dry -= elsewhere
                dry = 0.0 if dry < 0.0 else dry  # a NaN stays one, and shows in the motion
                break_away = base_break_away + (dry - base_dry)
                break_away = break_away if break_away > 0.0 else 0.0
            load = output_torque
            if stops:
                load += end_stop_torque(output_angle, output_speed, stop_lower, stop_upper, stiffness, damping)
            dry_now = dry
            held = break_away
            net = drive_torque - torque
            load_dry = output_dry
            load_held = output_break_away
            if asymmetry != 0.0:
                factor = directed(asymmetry, speed, net - (load if rigid else transmitted))
                dry_now *= factor
                held *= factor
                net -= asymmetry * (viscous + thinned) * math.fabs(speed)
                load_factor = directed(asymmetry, output_speed, transmitted - load)
                load_dry *= load_factor
                load_held *= load_factor
                if not rigid:
                    load += asymmetry * output_viscous * math.fabs(output_speed)
            if bristled:
                bristle, bristle_torque = bristle_step(
                    bristle,
                    speed,
                    dry_now,
                    plant.bristle_stiffness * motor_share,
                    plant.bristle_damping * motor_share,
                    h,
                )
                net -= bristle_torque
                dry_now = held = 0.0
                if not rigid:
                    output_bristle, bristle_torque = bristle_step(
                        output_bristle,
                        output_speed,
                        load_dry,
                        plant.bristle_stiffness * (1.0 - motor_share),
                        plant.bristle_damping * (1.0 - motor_share),
                        h,
                    )
                    load += bristle_torque
                    load_dry = load_held = 0.0
            before = speed
            if rigid:
                speed = shaft_speed(speed, net - load, dry_now, held, motor_gain, motor_drag)
                angle += 0.5 * h * speed
                output_angle = angle - twist
                output_speed = speed
            else:
                transmitted = contact_torque(
                    angle - output_angle - 0.5 * h * (speed - output_speed),
                    speed - output_speed,
                    stiffness,
                    damping,
                    gap,
                    h,
                    0.5 * h * softness,
                )
                speed = shaft_speed(speed, net - transmitted, dry_now, held, motor_gain, motor_drag)
                output_speed = shaft_speed(
                    output_speed, transmitted - load, load_dry, load_held, output_gain, output_drag
                )
                angle += 0.5 * h * speed
                output_angle += 0.5 * h * output_speed
            smoothed += smoothing_gain * (0.5 * (before + speed) - smoothed)
            if acting or k == steps - 1:
                # what effects may ask of the step before; no effect, nobody asks until the interval's end
                acceleration = (speed - before) * per_step
                if rigid:
                    sense = 1.0 if speed > 0.0 else (-1.0 if speed < 0.0 else 0.0)
                    transmitted = output_inertia * acceleration + output_viscous * speed + output_dry * sense + load
        time += interval

        if not record:
            continue
        twin[row, 0] = bench[row, CURRENT_IN] if source == CURRENT else current
        twin[row, 1] = math.nan if source == CURRENT else current_setpoint
        twin[row, 2] = smoothed
        twin[row, 3] = math.nan if source == CURRENT else setpoint
        twin[row, 4] = counted(angle, plant.motor_counts)
        twin[row, 5] = counted(shown(plant, state, output_angle, phase) - state.encoder_zero, plant.output_counts)
        twin[row, 6] = bench[row, COMMAND_IN]
        twin[row, 7] = quadrature_voltage(plant, speed, current, current_rate)
        twin[row, 8] = plant.torque_constant * current
        twin[row, 9] = transmitted
        twin[row, 10] = unexplained_torque(plant, state, effects, bench, row, interval, time, h)

    state.time = time
    state.motor_angle = angle
    state.motor_speed = speed
    state.output_angle = output_angle
    state.output_speed = output_speed
    state.twist = angle - output_angle
    state.current = current
    state.current_setpoint = current_setpoint
    state.integral = integral
    state.speed_setpoint = setpoint
    state.smoothed_speed = smoothed
    state.control_phase = phase
    state.bristle = bristle
    state.output_bristle = output_bristle
    state.acceleration = acceleration
    state.transmitted_torque = transmitted

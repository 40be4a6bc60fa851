"""The other plant, compiled: bristle friction, always two inertias (three behind a soft coupling), its own drive.

Nothing of the twin is in it. Friction is an elasto-plastic bristle (Dupont, Hayward, Armstrong, Altpeter 2002), or a
LuGre one (Canudas de Wit et al. 1995) where presliding friction is hidden, on both sides of a spring; the integrator is
semi-implicit Euler at 15.6 us; what swings with an angle is one table of harmonics. Angles of both shafts are at the
fast one.
"""

import math

import numpy as np
from numba import boolean, float64, from_dtype, int64, njit, void

from .layout import ON_MOTOR, ON_MOTOR_LEVEL, ON_MOTOR_TORQUE, ON_OUTPUT, PLANT, SMOOTH_LAWS, STEP, STRIBECK_LAWS

_MEMORY = 2048  # steps that the output encoder's line remembers: 32 ms
GAUSSIAN, LORENTZIAN = STRIBECK_LAWS.index("gaussian"), STRIBECK_LAWS.index("lorentzian")
TANH, ARCTANGENT = SMOOTH_LAWS.index("tanh"), SMOOTH_LAWS.index("arctangent")


@njit(inline="always")
def _within(value, limit):
    return min(max(value, -limit), limit)


@njit(inline="always")
def _bristle(bend, speed, level, stiffness, elastic):
    """The bristle's bend [rad] after a step of sliding at ``speed``; ``elastic`` < 0 is a LuGre bristle."""
    if level <= 0.0:
        return 0.0
    full = level / stiffness
    plastic = 1.0
    if elastic >= 0.0:
        # springs back wholly up to a share of its full bend, then gives way more and more
        reach = abs(bend) / full
        share = min(max((reach - elastic) / (1.0 - elastic), 0.0), 1.0)
        plastic = share * share * (3.0 - 2.0 * share) if bend * speed > 0.0 else 0.0
    after = (bend + STEP * speed) / (1.0 + STEP * plastic * abs(speed) / full)
    return _within(after, full)


@njit(inline="always")
def _built_up(share, law):
    """Share of the dry level at a ``share`` of the transition speed."""
    if law == TANH:
        return math.tanh(share)
    return 2.0 / math.pi * math.atan(0.5 * math.pi * share) if law == ARCTANGENT else share / math.hypot(1.0, share)


@njit(inline="always")
def _contact(twist, rate, stiffness, damping, half_gap):
    """Torque [N m] that a spring and damper pass on; behind a gap they push and never pull."""
    if half_gap == 0.0:
        return stiffness * twist + damping * rate
    if twist > half_gap:
        return max(stiffness * (twist - half_gap) + damping * rate, 0.0)
    if twist < -half_gap:
        return min(stiffness * (twist + half_gap) + damping * rate, 0.0)
    return 0.0


@njit(
    void(
        from_dtype(PLANT)[::1],
        float64[:, ::1],
        float64[:, ::1],
        float64[::1],
        float64[::1],
        int64,
        int64[::1],
        int64,
        float64,
        boolean,
        float64[:, ::1],
    ),
    cache=True,
    nogil=True,
    error_model="numpy",
)
def run(plants, harmonics, bursts, command, speed_noise, cycle, samples, held, start_twist, calm, trace):
    """Run the bench from rest and write a row of ``trace`` (m, len(TRACE)) at each step named in ``samples`` (m,).

    ``command`` (c,) [rad, slow shaft] and ``speed_noise`` (c,) [rad/s] hold one value a control cycle of ``cycle``
    steps. For the first ``held`` steps the drive holds the command's first value, and time stands at zero.
    ``start_twist`` [rad] is where in the gap the motor starts; ``calm`` says that friction neither wanders nor warms.
    """
    p = plants[0]
    ratio = p.ratio
    two_pi = 2.0 * math.pi
    current_gain = 1.0 - math.exp(-STEP / p.current_lag)
    smoothing_gain = 1.0 - math.exp(-STEP / p.smoothing)
    period = cycle * STEP
    filter_gain = 1.0 - math.exp(-period / p.filter)
    levels = p.motor_level + p.output_level
    motor_bristle = p.bristle_stiffness * p.motor_level / levels
    output_bristle = p.bristle_stiffness * p.output_level / levels
    motor_bristle_damping = p.bristle_damping * p.motor_level / levels
    output_bristle_damping = p.bristle_damping * p.output_level / levels
    viscous = p.motor_viscous + p.output_viscous
    coupled = p.load_share > 0.0
    ring_inertia = p.output_inertia * (1.0 - p.load_share)
    load_inertia = p.output_inertia * p.load_share
    memory = np.zeros(_MEMORY)
    behind = p.delay / STEP

    angle = start_twist
    speed = out = out_speed = load = load_speed = 0.0
    bend = out_bend = 0.0
    current = wanted_current = current_rate = integral = setpoint = smoothed = passed = 0.0
    mood = 1.0  # what friction is multiplied by
    thinned = 0.0  # change of the viscous coefficient by warming
    burst = 0
    next_sample = 0
    origin_angle = start_twist
    origin_out = 0.0

    for k in range(samples[-1] + held + 1):
        step = k - held
        time = max(step, 0) * STEP
        if step == 0:
            origin_angle = angle
            origin_out = out

        # what the output encoder shows: late, off its centre, wavy within its lines
        memory[k % _MEMORY] = out
        seen = out
        if behind > 0.0:
            whole = int(behind)
            part = behind - whole
            newer = memory[max(k - whole, 0) % _MEMORY]
            older = memory[max(k - whole - 1, 0) % _MEMORY]
            seen = newer + part * (older - newer)
        shown = (seen - origin_out) / ratio
        first = p.output_origin + p.eccentricity_phase
        if p.eccentricity != 0.0:
            shown += p.eccentricity * (math.sin(first + shown) - math.sin(first))
        if p.interpolation != 0.0:
            lines = p.interpolation_lines
            shown += p.interpolation * (math.sin(lines * (p.output_origin + shown)) - math.sin(lines * p.output_origin))

        # the trace is taken before the control cycle of that instant runs
        if step >= 0 and step == samples[next_sample]:
            trace[next_sample, 0] = current
            trace[next_sample, 1] = wanted_current
            trace[next_sample, 2] = smoothed
            trace[next_sample, 3] = setpoint
            trace[next_sample, 4] = angle - origin_angle
            trace[next_sample, 5] = shown
            trace[next_sample, 6] = p.back_emf * speed + p.resistance * current + p.inductance * current_rate
            next_sample += 1

        if k % cycle == 0:
            tick = max(step, 0) // cycle
            error = command[tick] - shown
            setpoint += filter_gain * (_within(p.position_gain * error, p.speed_limit) - setpoint)
            speed_error = setpoint - speed - speed_noise[tick]
            demand = p.speed_gain * speed_error + integral
            torque = _within(demand, p.torque_limit)
            if abs(error) * ratio > p.dead_band:
                rate = p.speed_gain / p.integral_time * speed_error + (torque - demand) / p.anti_windup
                integral = _within(integral + period * rate, p.integral_limit)
            wanted_current = torque / p.believed_torque_constant
            if not calm:
                thinned = -p.warming * viscous * (1.0 - math.exp(-time / p.warming_time))
                mood = 1.0 + p.wander * (
                    0.6 * math.sin(two_pi * time / p.wander_period + p.wander_phase)
                    + 0.4 * math.sin(two_pi * time / p.wander_period_2 + p.wander_phase_2)
                )

        change = current_gain * (wanted_current - current)
        current += change
        current_rate = change / STEP
        motor_torque = p.torque_constant * current

        # torques and dry levels that swing with an angle
        motor_angle = p.motor_origin + angle - origin_angle
        output_angle = p.output_origin + (out - origin_out) / ratio
        net = motor_torque
        level = p.motor_level * mood
        out_load = p.constant_load + p.spring * (out - origin_out) / ratio
        out_level = p.output_level * mood
        for row in range(harmonics.shape[0]):
            action = harmonics[row, 3]
            own = motor_angle if action <= ON_MOTOR_TORQUE else output_angle
            swing = harmonics[row, 0] * math.sin(harmonics[row, 1] * own + harmonics[row, 2])
            if action == ON_MOTOR:
                net -= swing
            elif action == ON_MOTOR_LEVEL:
                level += swing
            elif action == ON_MOTOR_TORQUE:
                net += motor_torque * swing
            elif action == ON_OUTPUT:
                out_load += swing
            else:
                out_level += swing
        if p.pulse != 0.0:
            turn = (p.pulse_order * motor_angle - p.pulse_position) / two_pi
            away = abs(turn - math.floor(turn + 0.5)) * two_pi
            if away < 0.5 * p.pulse_width:
                height = p.pulse * math.cos(math.pi * away / p.pulse_width) ** 2
                if p.pulse_is_level != 0.0:
                    level += height
                else:
                    net -= height
        while burst < bursts.shape[0] and time > bursts[burst, 1]:
            burst += 1
        if burst < bursts.shape[0] and time >= bursts[burst, 0]:
            level += bursts[burst, 2]
        pace = abs(speed)
        if p.stribeck_level != 0.0:
            share = pace / p.stribeck_speed
            if p.stribeck_law == LORENTZIAN:
                level += p.stribeck_level / (1.0 + share * share)
            else:
                level += p.stribeck_level * math.exp(-share * share if p.stribeck_law == GAUSSIAN else -share)
        if p.bump_level != 0.0:
            level += p.bump_level * math.exp(-(((pace - p.bump_speed) / p.bump_width) ** 2))
        level += p.mesh_coefficient * abs(passed)
        if level < 0.0:  # the total stays above zero: the output's level gives what the motor's lacks
            out_level = max(out_level + level, 0.0)
            level = 0.0
        drag = p.motor_viscous * mood + thinned
        if p.thinning != 0.0:
            drag -= p.thinning * viscous * pace / (pace + p.thinning_speed)
        out_drag = p.output_viscous * mood
        if p.smooth_speed != 0.0:
            level *= _built_up(pace / p.smooth_speed, p.smooth_law)
            out_level *= _built_up(abs(out_speed) / p.smooth_speed, p.smooth_law)
        if p.asymmetry != 0.0:
            forward = 1.0 + p.asymmetry if speed >= 0.0 else 1.0 - p.asymmetry
            level *= forward
            drag *= forward
            forward = 1.0 + p.asymmetry if out_speed >= 0.0 else 1.0 - p.asymmetry
            out_level *= forward
            out_drag *= forward
        drag += p.drag * pace

        after = _bristle(bend, speed, level, motor_bristle, p.elastic_share)
        net -= motor_bristle * after + motor_bristle_damping * (after - bend) / STEP
        bend = after
        after = _bristle(out_bend, out_speed, out_level, output_bristle, p.elastic_share)
        out_load += output_bristle * after + output_bristle_damping * (after - out_bend) / STEP
        out_bend = after

        passed = _contact(angle - out, speed - out_speed, p.stiffness, p.damping, p.half_gap)
        beyond = 0.0
        if coupled:
            beyond = p.load_stiffness * (out - load) + p.load_damping * (out_speed - load_speed)
            load_speed += STEP / load_inertia * beyond
            load += STEP * load_speed
        gain = STEP / p.motor_inertia
        before = speed
        speed = (speed + gain * (net - passed)) / (1.0 + gain * drag)
        gain = STEP / ring_inertia
        out_speed = (out_speed + gain * (passed - out_load - beyond)) / (1.0 + gain * out_drag)
        angle += STEP * speed
        out += STEP * out_speed
        smoothed += smoothing_gain * (0.5 * (before + speed) - smoothed)

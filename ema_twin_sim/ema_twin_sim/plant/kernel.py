"""The compiled step of the twin: one loop for a whole recording, for one live sample, and for the virtual bench.

``advance`` integrates from each row's stamp to the next with the input interpolated between both, in equal steps of at
most ``step`` seconds, and writes what the bench's sensors would show at each stamp. A live twin calls it with two rows,
an offline run with all of them: the arithmetic is the same, so are the results.

One text, compiled for the fidelity that a model asks for (``kernel``): what a fidelity has not is left out of its
machine code. Beside the averaged drive and the lumped transmission, a drive may switch (``switching/``), and a
transmission be a planetary train (``planetary/``): then the step is about 1 us, and effects, which change over
milliseconds, are taken every EFFECT_PERIOD.
"""

import logging
import math
import threading
from collections.abc import Callable
from functools import cache
from typing import Any

from numba import boolean, float64, from_dtype, int64, njit, types, void
from numba.core.event import Event, Listener, install_listener

from .balance import unexplained_torque
from .drive import lag_gain, limited, quadrature_voltage, speed_controller
from .energy import (
    EFFECTS,
    LOAD,
    MOTOR,
    MOTOR_DRY,
    MOTOR_VISCOUS,
    OUTPUT_DRY,
    OUTPUT_VISCOUS,
    SHAFT,
    STIFFNESS_CHANGE,
    account_drive,
    account_meshes,
    friction_energies,
    keep_speeds,
    stored_in_meshes,
)
from .evaluate import evaluate
from .friction import bristle_share, bristle_step, directed
from .layout import (
    BENCH,
    COMMAND_IN,
    CURRENT,
    CURRENT_IN,
    LOAD_IN,
    PLANT,
    SETPOINT,
    SETPOINT_IN,
    STANDALONE_SPEED,
    STATE,
)
from .operating_point import PARAMETER_SLOTS, OperatingPoint
from .planetary.layout import TRAIN, TRAIN_STATE, TURN
from .planetary.mesh_state import mesh_cycles, moved_on, read_friction, read_meshes
from .planetary.train import train_step
from .planetary.train_constants import train_constants
from .sensors import counted, remember, shown
from .switching.electrical_angle import sine_and_cosine, turned
from .switching.layout import WINDING, WINDING_STATE
from .switching.step import switching_step
from .switching.step_constants import step_constants
from .transmission import contact_torque, end_stop_torque, response, shaft_speed

EFFECT_PERIOD = 25e-6
"""s, after which effects are taken again where steps are shorter."""

_ONE_AT_A_TIME = threading.Lock()
"""Threads that ask for the same kernel compile it once."""

_PLANT = from_dtype(PLANT)
_STATE = from_dtype(STATE)
_STAMPS = types.Array(int64, 1, "C", readonly=True)
_EFFECTS = types.Tuple((int64[::1], int64[::1], float64[:, ::1]))
"""Addresses (n,), places (n,), parameters (n, 4) of the effects that depend on the operating point."""
_FINE = types.Tuple(
    (
        from_dtype(WINDING)[::1],
        from_dtype(WINDING_STATE)[::1],
        from_dtype(TRAIN)[::1],
        from_dtype(TRAIN_STATE)[::1],
        float64[::1],
        float64[:, :, ::1],
        float64[::1],
        _EFFECTS,
    )
)
"""Records (1,) of winding and train with their states, the train's lanes, its mesh table, the energies (energy.py), and
the effects that are balanced where they are others than those that act."""

_SIGNATURE = void(
    _PLANT[::1], _STATE[::1], _EFFECTS, _FINE, int64, _STAMPS, float64[:, ::1], float64[:, ::1], float64, boolean
)

assert PARAMETER_SLOTS == 4 and len(BENCH) == 6  # the calls and columns below are written out


class _Compiling(Listener):
    """Logs that a kernel is being compiled, and not just read from disk."""

    def __init__(self, what: str) -> None:
        self._what = what
        self._told = False

    def on_start(self, event: Event) -> None:
        if not self._told:
            self._told = True
            logging.getLogger(__name__).info("compiling the equations of the %s: once, 10 to 20 s", self._what)

    def on_end(self, event: Event) -> None:
        pass


def kernel(switching: bool, planetary: bool, accounting: bool = False) -> Callable[..., Any]:
    """``advance`` for a fidelity, compiled when first asked for (seconds, told by a log line) and kept on disk.

    ``accounting`` books every energy too, which makes a step 1.7 to 1.9 times as long.
    """
    drive, transmission = "switching" if switching else "averaged", "planetary" if planetary else "lumped"
    with _ONE_AT_A_TIME, install_listener("numba:compile", _Compiling(f"{drive} drive, {transmission} transmission")):
        return _compiled(switching, planetary, accounting)


@cache
def _compiled(switching: bool, planetary: bool, accounting: bool) -> Callable[..., Any]:
    fine = switching or planetary
    # a fine step is a long chain of products and sums, which fuse where the processor can
    fused = {"contract"} if fine else False

    @njit(_SIGNATURE, cache=True, nogil=True, error_model="numpy", fastmath=fused)
    def advance(plants, states, effects, fine_parts, source, stamps, bench, twin, step, record):
        """Integrate over ``stamps`` [ns] (n,) and fill rows 1… of ``twin`` (n, signals); row 0 is the state's own.

        ``bench`` (n, 6) holds the columns ``layout.BENCH``, NaN where the machine lacks one; ``source`` is one of
        ``layout.INPUTS``, ``fine_parts`` are ``simulation.fidelity.Fine``. ``record`` false integrates without writing
        (to time the equations alone).
        """
        plant = plants[0]
        state = states[0]
        windings, winding_states, trains, train_states, lanes, table, energies, balanced_effects = fine_parts
        ratio = plant.gear_ratio
        per_ratio = 1.0 / ratio
        rigid = plant.two_inertia == 0.0 and not planetary
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
        pole_pairs = plant.pole_pairs
        viscous_total = plant.motor_viscous + plant.output_viscous
        # what the motor's shaft carries itself: everything where the transmission is rigid
        inertia = plant.motor_inertia + (plant.output_inertia if rigid else 0.0)
        if planetary:
            inertia = trains[0].input_inertia
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
        plain = not (acting or stops or asymmetry != 0.0 or bristled)
        balanced = balanced_effects if fine else effects
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
        output_start = state.output_start
        twist = state.twist
        reaction = 0.0
        by_inverter = switching and source != CURRENT
        winding_state = winding_states[0]
        current_u = winding_state.phase_current_u
        current_v = winding_state.phase_current_v
        current_w = winding_state.phase_current_w
        leg_u = winding_state.leg_u
        leg_v = winding_state.leg_v
        leg_w = winding_state.leg_w
        direct_current = winding_state.direct_current
        voltage = winding_state.quadrature_voltage
        winding = step_constants(windings[0], step)
        sine, cosine = 0.0, 1.0
        train = trains[0]
        train_of_step = train_constants(train, motor_origin, step)
        moving = train_states[0]
        flexible = planetary and train.shaft_stiffness > 0.0
        sun_angle = moving.sun_angle
        sun_speed = moving.sun_speed
        carrier_angle = moving.carrier_angle
        carrier_speed = moving.carrier_speed
        drive_torque = torque_constant * current
        effects_in = 0

        column = (
            CURRENT_IN if source == CURRENT else (SETPOINT_IN if source in (SETPOINT, STANDALONE_SPEED) else COMMAND_IN)
        )
        step = plant.control_cycle / math.ceil(plant.control_cycle / step - 1e-9)  # so that cycles begin on a step
        h = per_step = 0.0
        interval_before = int64(-1)
        current_gain = setpoint_gain = smoothing_gain = 0.0
        motor_gain = motor_drag = output_gain = output_drag = 0.0
        steps = effect_steps = 1

        for row in range(1, stamps.shape[0]):
            nanoseconds = stamps[row] - stamps[row - 1]
            interval = nanoseconds * 1e-9
            if nanoseconds != interval_before:
                interval_before = nanoseconds
                steps = max(1, math.ceil(interval / step - 1e-9))
                h = interval / steps
                effect_steps = max(1, round(EFFECT_PERIOD / h)) if fine else 1
                per_step = 1.0 / h
                motor_gain, motor_drag = response(h, inertia, viscous)
                output_gain, output_drag = response(h, plant.output_inertia, plant.output_viscous)
                current_gain = lag_gain(h, plant.current_lag)
                smoothing_gain = lag_gain(h, plant.speed_smoothing)
                if switching:
                    winding = step_constants(windings[0], h)
                if planetary:
                    train_of_step = train_constants(train, motor_origin, h)
                setpoint_gain = lag_gain(plant.control_cycle, plant.speed_setpoint_filter)
            effects_in = 0  # at every sample, so that a live twin takes them when an offline one does
            start = bench[row - 1, column]
            slope = bench[row, column] - start
            load_start = bench[row - 1, LOAD_IN]
            load_slope = (bench[row, LOAD_IN] - load_start) / steps
            current_rate = 0.0

            for k in range(steps):
                # drive
                cycle_begins = phase >= plant.control_cycle - 0.5 * h
                if source == CURRENT:
                    given = start + slope * ((k + 0.5) / steps)
                    current_rate = (given - current) * per_step
                    current = given
                    if cycle_begins:
                        phase -= plant.control_cycle
                        remember(state, output_angle)
                        if planetary:
                            read_friction(train, moving, lanes, speed, output_speed * per_ratio)
                else:
                    if cycle_begins:
                        phase -= plant.control_cycle
                        remember(state, output_angle)
                        if planetary:
                            read_friction(train, moving, lanes, speed, output_speed * per_ratio)
                        given = start + slope * (k / steps)
                        integrate = True
                        if source == SETPOINT:
                            # a trace is sampled before its stamp's cycle runs: it shows a setpoint one cycle later
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
                    if not switching:
                        change = current_gain * (current_setpoint - current)
                        current_rate = change * per_step
                        current += change
                phase += h
                drive_torque = torque_constant * current
                if by_inverter:
                    middle = motor_origin + angle + 0.5 * h * speed
                    if k == 0 or cycle_begins:
                        sine, cosine = sine_and_cosine(winding.pole_pairs * middle / TURN)
                    else:
                        sine, cosine = turned(sine, cosine, winding.pole_pairs * h * speed)
                    (
                        current_u, current_v, current_w, leg_u, leg_v, leg_w, current, direct_current, voltage,
                        drive_torque, gap_torque, link_power, winding_loss,
                    ) = switching_step(
                        winding, current_u, current_v, leg_u, leg_v, leg_w, current, direct_current, voltage,
                        current_setpoint, middle, sine, cosine, speed,
                    )  # fmt: skip
                    if accounting:
                        account_drive(energies, h, speed, gap_torque, link_power, winding_loss)

                # mechanics: half the drift, then the kick at the middle of the step
                if not (rigid or planetary):
                    twist = angle - output_angle
                angle += 0.5 * h * speed
                if not rigid:
                    output_angle += 0.5 * h * output_speed
                net = drive_torque
                load = load_start + load_slope * (k + 0.5)
                dry_now = base_dry
                held = base_break_away
                load_dry = output_dry
                load_held = output_break_away
                if not plain:  # one question instead of four where a model has none of these
                    if rigid:
                        output_angle = angle - twist
                        output_speed = speed
                    if acting and effects_in == 0:
                        effects_in = effect_steps
                        at = OperatingPoint(
                            time + k * h,
                            motor_origin + angle,
                            pole_pairs * (motor_origin + angle),
                            speed,
                            output_origin + output_angle * per_ratio,
                            (output_angle - output_start) * per_ratio,
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
                    effects_in -= 1
                    dry_now = dry
                    held = break_away
                    net -= torque
                    load += output_torque
                    if stops:
                        load += end_stop_torque(output_angle, output_speed, stop_lower, stop_upper, stiffness, damping)
                    if asymmetry != 0.0:
                        passed = reaction if planetary else transmitted
                        factor = directed(asymmetry, speed, net - (load if rigid else passed))
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
                output_before = output_speed
                if planetary:
                    sun_at, sun_before = (sun_angle + 0.5 * h * sun_speed, sun_speed) if flexible else (angle, speed)
                    carrier_at = carrier_angle + 0.5 * h * carrier_speed
                    output_at = output_angle * per_ratio
                    cycles = mesh_cycles(train_of_step, sun_at, carrier_at, output_at)
                    if moved_on(train, moving, cycles):
                        if accounting:
                            energies[STIFFNESS_CHANGE] -= stored_in_meshes(
                                train, moving, lanes, sun_at - 0.5 * h * sun_before, sun_before,
                                output_at - 0.5 * h * output_speed * per_ratio, output_speed * per_ratio, h,
                            )  # fmt: skip
                        read_meshes(train, moving, lanes, table, cycles)
                        if accounting:
                            energies[STIFFNESS_CHANGE] += stored_in_meshes(
                                train, moving, lanes, sun_at - 0.5 * h * sun_before, sun_before,
                                output_at - 0.5 * h * output_speed * per_ratio, output_speed * per_ratio, h,
                            )  # fmt: skip
                    if accounting:
                        keep_speeds(lanes, moving)
                    on_sun, on_output, carrier_angle, carrier_speed = train_step(
                        train_of_step, moving.friction_coefficient, lanes, sun_at, sun_before, carrier_at,
                        carrier_speed, output_at, output_speed * per_ratio,
                    )  # fmt: skip
                    moving.carrier_angle = carrier_angle
                    moving.carrier_speed = carrier_speed
                    reaction = -on_sun
                    if flexible:
                        reaction = train.shaft_stiffness * (angle - sun_at) + train.shaft_damping * (speed - sun_speed)
                        sun_speed += h * (reaction + on_sun) / train.sun_inertia
                        sun_angle = sun_at + 0.5 * h * sun_speed
                    transmitted = on_output * per_ratio
                    speed = shaft_speed(speed, net - reaction, dry_now, held, motor_gain, motor_drag)
                    output_speed = shaft_speed(
                        output_speed, transmitted - load, load_dry, load_held, output_gain, output_drag
                    )
                    angle += 0.5 * h * speed
                    output_angle += 0.5 * h * output_speed
                elif rigid:
                    speed = shaft_speed(speed, net - load, dry_now, held, motor_gain, motor_drag)
                    angle += 0.5 * h * speed
                    output_angle = angle - twist
                    output_speed = speed
                else:
                    transmitted = contact_torque(
                        twist,
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
                if accounting:
                    passed = reaction if planetary else (load if rigid else transmitted)
                    mean = friction_energies(
                        energies, MOTOR_VISCOUS, MOTOR_DRY, h, before, speed, net - passed, viscous, dry_now, inertia,
                    )  # fmt: skip
                    energies[MOTOR] += h * drive_torque * mean
                    energies[EFFECTS] += h * (drive_torque - net) * mean
                    if not rigid:
                        mean = friction_energies(
                            energies, OUTPUT_VISCOUS, OUTPUT_DRY, h, output_before, output_speed, transmitted - load,
                            output_viscous, load_dry, output_inertia,
                        )  # fmt: skip
                    energies[LOAD] += h * load * mean
                    if planetary:
                        account_meshes(
                            energies, h, train, moving, lanes, sun_before, sun_speed if flexible else speed,
                            output_before * per_ratio, output_speed * per_ratio,
                        )  # fmt: skip
                        if flexible:
                            turning = 0.5 * (before + speed - sun_before - sun_speed)
                            energies[SHAFT] += h * reaction * turning
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
            twin[row, 7] = voltage if by_inverter else quadrature_voltage(plant, speed, current, current_rate)
            twin[row, 8] = drive_torque
            twin[row, 9] = transmitted
            twin[row, 10] = unexplained_torque(plant, state, balanced, bench, row, interval, time, h)
            if by_inverter:
                twin[row, 11] = direct_current
                twin[row, 12] = current_u
                twin[row, 13] = current_v
                twin[row, 14] = current_w
            else:
                twin[row, 11:15] = math.nan

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
        if switching:
            winding_state.phase_current_u = current_u
            winding_state.phase_current_v = current_v
            winding_state.phase_current_w = current_w
            winding_state.leg_u = leg_u
            winding_state.leg_v = leg_v
            winding_state.leg_w = leg_w
            winding_state.quadrature_current = current
            winding_state.direct_current = direct_current
            winding_state.quadrature_voltage = voltage
        if planetary:
            moving.sun_angle = sun_angle if flexible else angle
            moving.sun_speed = sun_speed if flexible else speed

    return advance

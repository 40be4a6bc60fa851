"""The compiled loop of the twin, the same for a whole recording, one live sample, and the virtual bench.

``advance`` integrates from each row's stamp to the next with linearly interpolated input, in equal steps of at most
``step`` seconds, and writes the sensor readings at each stamp. A live twin calls it with two rows, an offline run with
all of them: the arithmetic is the same, so are the results.

One source, compiled for the fidelity that a model needs (``kernel``): parts that a fidelity lacks are left out of its
machine code. Besides the averaged drive and the lumped transmission there are a switching drive (``switching/``) and a
planetary train (``planetary/``): then the step is about 1 us, and effects, which change over milliseconds, are
evaluated every EFFECT_PERIOD.

The parts of a step are in separate files (``drive.py``, ``friction.py``, ``transmission.py``, ``planetary/``,
``switching/``, ``row.py``), which other loops use, too (``many.py``, ``driven_output.py``, ``measured_motion.py``). The
unexplained torque is a separate pass over the measured data (``balance.py``).
"""

import logging
import math
import threading
from collections.abc import Callable
from functools import cache
from typing import Any

from numba import boolean, float64, int64, njit, void
from numba.core.event import Event, Listener, install_listener

from .balance import estimate
from .drive import drive_step, lag_gain, quadrature_voltage
from .energy import LOAD, SHAFT, account_drive, account_meshes, account_motor, account_output, keep_speeds
from .evaluate import evaluate
from .friction import bristle_share, rubbing
from .layout import (
    COMMAND_IN,
    CURRENT,
    CURRENT_IN,
    LOAD_IN,
    OUT,
    SETPOINT,
    SETPOINT_IN,
    STANDALONE_SPEED,
)
from .operating_point import OperatingPoint
from .planetary.layout import TURN
from .planetary.mesh_state import follow_meshes, read_friction
from .planetary.train import train_step
from .planetary.train_constants import train_constants
from .row import Moment, write_row
from .sensors import remember
from .signatures import EFFECTS, FINE, PLANTS, STAMPS, STATES, TABLE
from .switching.electrical_angle import sine_and_cosine, turned
from .switching.step import switching_step
from .switching.step_constants import step_constants
from .time_steps import step_in_cycle, steps_in
from .transmission import end_stop_torque, lumped_step, passed_rigidly, shaft_speed, shafts_of

EFFECT_PERIOD = 25e-6
"""s, period at which effects are evaluated if steps are shorter."""

_ONE_AT_A_TIME = threading.Lock()
"""Ensures that threads that need the same kernel compile it once."""

_SIGNATURE = void(PLANTS, STATES, EFFECTS, EFFECTS, FINE, int64, STAMPS, TABLE, TABLE, float64, boolean)


class _Compiling(Listener):
    """Logs when a kernel is compiled rather than read from disk."""

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
    """``advance`` for a fidelity, compiled on first use (seconds, with a log line) and cached on disk.

    ``accounting`` also records every energy, which makes a step take 1.7 to 1.9 times as long.
    """
    drive, transmission = "switching" if switching else "averaged", "planetary" if planetary else "lumped"
    with _ONE_AT_A_TIME, install_listener("numba:compile", _Compiling(f"{drive} drive, {transmission} transmission")):
        return _compiled(switching, planetary, accounting)


@cache
def _compiled(switching: bool, planetary: bool, accounting: bool) -> Callable[..., Any]:
    fine = switching or planetary
    # a fine step is a long chain of products and sums, which are fused if the processor can
    fused = {"contract"} if fine else False

    @njit(_SIGNATURE, cache=True, nogil=True, error_model="numpy", fastmath=fused)
    def advance(plants, states, effects, balanced, fine_parts, source, stamps, bench, twin, step, record):
        """Integrate over ``stamps`` [ns] (n,) and fill rows 1… of ``twin`` (n, signals); row 0 is the initial state.

        ``bench`` (n, 6) holds the columns ``layout.BENCH``, NaN where the machine lacks one; ``source`` is one of
        ``layout.INPUTS``, ``fine_parts`` are ``layout.Fine``. The effects ``balanced`` are used to balance torques;
        they differ from the acting ones if a finer part simulates some. ``record`` false integrates without writing (to
        time the equations alone).
        """
        plant = plants[0]
        state = states[0]
        windings, winding_states, trains, train_states, lanes, table, energies = fine_parts
        by_current = source == CURRENT
        ratio = plant.gear_ratio
        per_ratio = 1.0 / ratio
        rigid = plant.two_inertia == 0.0 and not planetary
        stops = not (math.isinf(plant.end_stop_lower) and math.isinf(plant.end_stop_upper))
        # end stops refer to the encoder's own angle, wherever a recording starts
        stop_lower = (plant.end_stop_lower - state.output_angle_origin) * ratio
        stop_upper = (plant.end_stop_upper - state.output_angle_origin) * ratio
        # effects are opaque calls, across which a compiler does not keep values read from memory: hence local copies
        stiffness = plant.contact_stiffness
        damping = plant.contact_damping
        output_inertia = plant.output_inertia
        output_viscous = plant.output_viscous
        output_dry = plant.output_dry
        output_break_away = plant.output_break_away
        torque_constant = plant.torque_constant
        pole_pairs = plant.pole_pairs
        viscous_total = plant.motor_viscous + plant.output_viscous
        # inertia of the motor shaft: everything if the transmission is rigid
        inertia = plant.motor_inertia + (plant.output_inertia if rigid else 0.0)
        if planetary:
            inertia = trains[0].input_inertia
        viscous = plant.motor_viscous + (plant.output_viscous if rigid else 0.0)
        base_dry = plant.motor_dry + (plant.output_dry if rigid else 0.0)
        base_break_away = plant.motor_break_away + (plant.output_break_away if rigid else 0.0)
        asymmetry = plant.asymmetry
        bristled = plant.bristle_stiffness > 0.0
        share = 1.0 if rigid else bristle_share(plant)
        bristle_stiffness = plant.bristle_stiffness * share
        bristle_damping = plant.bristle_damping * share
        output_bristle_stiffness = plant.bristle_stiffness * (1.0 - share)
        output_bristle_damping = plant.bristle_damping * (1.0 - share)
        # effects see and change the dry level of the motor's side: with a rigid transmission, all of it
        acting = effects[0].shape[0] > 0
        plain = not (acting or stops or asymmetry != 0.0 or bristled)
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
        by_inverter = switching and not by_current
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

        column = CURRENT_IN if by_current else (SETPOINT_IN if source in (SETPOINT, STANDALONE_SPEED) else COMMAND_IN)
        step = step_in_cycle(plant.control_cycle, step)
        h = per_step = 0.0
        interval_before = int64(-1)
        current_gain = setpoint_gain = smoothing_gain = 0.0
        shafts = shafts_of(plant, inertia, viscous, step)
        steps = effect_steps = 1

        for row in range(1, stamps.shape[0]):
            nanoseconds = stamps[row] - stamps[row - 1]
            interval = nanoseconds * 1e-9
            if nanoseconds != interval_before:
                interval_before = nanoseconds
                steps = steps_in(interval, step)
                h = interval / steps
                effect_steps = max(1, round(EFFECT_PERIOD / h)) if fine else 1
                per_step = 1.0 / h
                shafts = shafts_of(plant, inertia, viscous, h)
                current_gain = lag_gain(h, plant.current_lag)
                smoothing_gain = lag_gain(h, plant.speed_smoothing)
                if switching:
                    winding = step_constants(windings[0], h)
                if planetary:
                    train_of_step = train_constants(train, motor_origin, h)
                setpoint_gain = lag_gain(plant.control_cycle, plant.speed_setpoint_filter)
            effects_in = 0  # at every sample, so that a live twin evaluates them when an offline one does
            start = bench[row - 1, column]
            slope = bench[row, column] - start
            load_start = bench[row - 1, LOAD_IN]
            load_slope = (bench[row, LOAD_IN] - load_start) / steps
            current_rate = 0.0

            for k in range(steps):
                cycle_begins = phase >= plant.control_cycle - 0.5 * h
                if cycle_begins:
                    phase -= plant.control_cycle
                    remember(state, output_angle)
                    if planetary:
                        read_friction(train, moving, lanes, speed, output_speed * per_ratio)
                    if not by_current:
                        setpoint, current_setpoint, integral = drive_step(
                            plant, state, source, start + slope * (k / steps), slope * (plant.control_cycle / interval),
                            setpoint_gain, setpoint, integral, speed, output_angle, phase,
                        )  # fmt: skip
                if by_current:
                    given = start + slope * ((k + 0.5) / steps)
                    current_rate = (given - current) * per_step
                    current = given
                elif not switching:
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

                # mechanics: half the drift, then the kick in the middle of the step
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
                if not plain:  # one test instead of four if a model has none of these
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
                            base_dry,
                            viscous_total,
                        )
                        torque, dry, output_torque, thinned = evaluate(effects, at)
                        break_away = base_break_away + (dry - base_dry)
                        break_away = break_away if break_away > 0.0 else 0.0
                    effects_in -= 1
                    net -= torque
                    load += output_torque
                    if stops:
                        load += end_stop_torque(output_angle, output_speed, stop_lower, stop_upper, stiffness, damping)
                    passed = load if rigid else (reaction if planetary else transmitted)
                    uneven, bent, dry_now, held, bristle = rubbing(
                        speed, net - passed, asymmetry, viscous + thinned, dry, break_away, bristled, bristle,
                        bristle_stiffness, bristle_damping, h,
                    )  # fmt: skip
                    net = net - uneven - bent
                    if not rigid:
                        uneven, bent, load_dry, load_held, output_bristle = rubbing(
                            output_speed, transmitted - load, asymmetry, output_viscous, load_dry, load_held, bristled,
                            output_bristle, output_bristle_stiffness, output_bristle_damping, h,
                        )  # fmt: skip
                        load = load + uneven + bent
                before = speed
                output_before = output_speed
                sun_before = sun_speed if flexible else speed
                if rigid:
                    speed = shaft_speed(speed, net - load, dry_now, held, shafts.gain, shafts.drag)
                    angle += 0.5 * h * speed
                    output_angle = angle - twist
                    output_speed = speed
                else:
                    if planetary:
                        sun_at = sun_angle + 0.5 * h * sun_speed if flexible else angle
                        carrier_at = carrier_angle + 0.5 * h * carrier_speed
                        output_at = output_angle * per_ratio
                        follow_meshes(
                            train_of_step, train, moving, lanes, table, sun_at, sun_before, carrier_at, output_at,
                            output_speed * per_ratio, h, energies, accounting,
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
                            reaction = train.shaft_stiffness * (angle - sun_at)
                            reaction += train.shaft_damping * (speed - sun_speed)
                            sun_speed += h * (reaction + on_sun) / train.sun_inertia
                            sun_angle = sun_at + 0.5 * h * sun_speed
                        transmitted = on_output * per_ratio
                        speed = shaft_speed(speed, net - reaction, dry_now, held, shafts.gain, shafts.drag)
                        output_speed = shaft_speed(
                            output_speed,
                            transmitted - load,
                            load_dry,
                            load_held,
                            shafts.output_gain,
                            shafts.output_drag,
                        )
                    else:
                        speed, output_speed, transmitted = lumped_step(
                            shafts, twist, speed, output_speed, net, load, dry_now, held, load_dry, load_held
                        )
                    angle += 0.5 * h * speed
                    output_angle += 0.5 * h * output_speed
                smoothed += smoothing_gain * (0.5 * (before + speed) - smoothed)
                if accounting:
                    passed = reaction if planetary else (load if rigid else transmitted)
                    mean = account_motor(
                        energies, h, before, speed, drive_torque, net, passed, viscous, dry_now, inertia
                    )
                    if rigid:
                        energies[LOAD] += h * load * mean
                    else:
                        account_output(
                            energies, h, output_before, output_speed, transmitted, load, output_viscous, load_dry,
                            output_inertia,
                        )  # fmt: skip
                    if planetary:
                        account_meshes(
                            energies, h, train, moving, lanes, sun_before, sun_speed if flexible else speed,
                            output_before * per_ratio, output_speed * per_ratio,
                        )  # fmt: skip
                        if flexible:
                            turning = 0.5 * (before + speed - sun_before - sun_speed)
                            energies[SHAFT] += h * reaction * turning
                if acting or k == steps - 1:
                    # needed by effects in the next step; without effects only at the interval's end
                    acceleration = (speed - before) * per_step
                    if rigid:
                        transmitted = passed_rigidly(plant, acceleration, speed, load)
            time += interval

            if record:
                at_sample = Moment(
                    phase=phase,
                    angle=angle,
                    speed=speed,
                    acceleration=acceleration,
                    output_angle=output_angle,
                    smoothed_speed=smoothed,
                    speed_setpoint=setpoint,
                    current=current,
                    current_setpoint=current_setpoint,
                    voltage=voltage if by_inverter else quadrature_voltage(plant, speed, current, current_rate),
                    torque=drive_torque,
                    transmitted=transmitted,
                )
                write_row(twin[row], bench[row], by_current, plant, state, at_sample)
                if by_inverter:
                    twin[row, OUT.direct_current] = direct_current
                    twin[row, OUT.phase_current_u] = current_u
                    twin[row, OUT.phase_current_v] = current_v
                    twin[row, OUT.phase_current_w] = current_w

        if record:
            estimate(plant, state, balanced, state.time, stamps, bench, twin, step)

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

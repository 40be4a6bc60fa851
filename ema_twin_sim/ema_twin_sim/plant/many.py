"""Several models of the averaged drive in parallel lanes: the kernel's own steps, with the model index innermost.

Steps of one model depend on each other; steps of several models do not, so a processor's wide registers compute them
together. For rigid and two-inertia transmissions whose effects only change constants, driven by a recorded speed
setpoint or current (``simulation/simulate_many.py`` decides which). The unexplained torque, which depends on the
measured motion only, is left out.
"""

from collections import namedtuple

import numpy as np
from numba import float64, int64, njit, types, void

from .compiled import inlined
from .drive import lag_gain, quadrature_voltage, speed_controller
from .friction import bristle_share, bristle_step
from .layout import CURRENT, CURRENT_IN, LOAD_IN, SETPOINT_IN
from .row import Moment, write_row
from .sensors import remember
from .signatures import PLANTS, STAMPS, STATES
from .time_steps import step_in_cycle, steps_in
from .transmission import Shafts, lumped_step, passed_rigidly, shaft_speed, shafts_of

LANE = 16
"""Number of parallel models: four of the widest usual registers, so that some work while others wait."""

Controller = namedtuple(
    "Controller",
    [
        "control_cycle",
        "current_limit",
        "torque_limit",
        "nominal_torque_constant",
        "speed_gain",
        "integral_time",
        "integral_limit",
        "anti_windup_time",
    ],
)
"""Constants of a plant used by the speed controller (``drive.py``)."""

LANES = 44 * LANE
"""Length of the flat array of lanes: the first quantity of all models comes first."""

(
    # controller
    CONTROL_CYCLE,
    CURRENT_LIMIT,
    TORQUE_LIMIT,
    NOMINAL_TORQUE_CONSTANT,
    SPEED_GAIN,
    INTEGRAL_TIME,
    INTEGRAL_LIMIT,
    ANTI_WINDUP_TIME,
    TORQUE_CONSTANT,
    CURRENT_GAIN,
    SMOOTHING_GAIN,
    # each inertia's response to a step, and its dry friction
    GAIN,
    DRAG,
    DRY,
    BREAK_AWAY,
    OUTPUT_GAIN,
    OUTPUT_DRAG,
    OUTPUT_DRY,
    OUTPUT_BREAK_AWAY,
    # the contact
    STIFFNESS,
    DAMPING,
    GAP,
    COMPLIANCE,
    # each side's bristle, whose torque replaces dry friction
    LEVEL,
    BRISTLE_STIFFNESS,
    BRISTLE_DAMPING,
    OUTPUT_LEVEL,
    OUTPUT_BRISTLE_STIFFNESS,
    OUTPUT_BRISTLE_DAMPING,
    BRISTLE,
    OUTPUT_BRISTLE,
    BENT,
    OUTPUT_BENT,
    # state
    ANGLE,
    SPEED,
    OUTPUT_ANGLE,
    OUTPUT_SPEED,
    AMPERES,
    AMPERES_WANTED,
    INTEGRAL,
    SMOOTHED,
    # of the last step
    SPEED_BEFORE,
    CHANGE,
    TRANSMITTED,
) = range(0, LANES, LANE)


@njit(error_model="numpy")
def _settle(plants, lanes, h, by_current):
    """Set the constants that depend on the step length ``h`` [s]."""
    for m in range(LANE):
        plant = plants[m]
        rigid = plant.two_inertia == 0.0
        inertia = plant.motor_inertia + (plant.output_inertia if rigid else 0.0)
        viscous = plant.motor_viscous + (plant.output_viscous if rigid else 0.0)
        shafts = shafts_of(plant, inertia, viscous, h)
        lanes[GAIN + m], lanes[DRAG + m] = shafts.gain, shafts.drag
        lanes[OUTPUT_GAIN + m], lanes[OUTPUT_DRAG + m] = shafts.output_gain, shafts.output_drag
        lanes[STIFFNESS + m], lanes[DAMPING + m] = shafts.stiffness, shafts.damping
        lanes[GAP + m], lanes[COMPLIANCE + m] = shafts.gap, shafts.compliance
        lanes[CURRENT_GAIN + m] = 1.0 if by_current else lag_gain(h, plant.current_lag)
        lanes[SMOOTHING_GAIN + m] = lag_gain(h, plant.speed_smoothing)


@njit(error_model="numpy")
def _load(plants, states, lanes):
    """Load constants and states of all models into their lanes."""
    for m in range(LANE):
        plant = plants[m]
        state = states[m]
        rigid = plant.two_inertia == 0.0
        lanes[CONTROL_CYCLE + m] = plant.control_cycle
        lanes[CURRENT_LIMIT + m] = plant.current_limit
        lanes[TORQUE_LIMIT + m] = plant.torque_limit
        lanes[NOMINAL_TORQUE_CONSTANT + m] = plant.nominal_torque_constant
        lanes[SPEED_GAIN + m] = plant.speed_gain
        lanes[INTEGRAL_TIME + m] = plant.integral_time
        lanes[INTEGRAL_LIMIT + m] = plant.integral_limit
        lanes[ANTI_WINDUP_TIME + m] = plant.anti_windup_time
        lanes[TORQUE_CONSTANT + m] = plant.torque_constant
        dry = plant.motor_dry + (plant.output_dry if rigid else 0.0)
        if plant.bristle_stiffness > 0.0:
            share = 1.0 if rigid else bristle_share(plant)
            lanes[LEVEL + m] = dry
            lanes[BRISTLE_STIFFNESS + m] = plant.bristle_stiffness * share
            lanes[BRISTLE_DAMPING + m] = plant.bristle_damping * share
            lanes[OUTPUT_LEVEL + m] = plant.output_dry
            lanes[OUTPUT_BRISTLE_STIFFNESS + m] = plant.bristle_stiffness * (1.0 - share)
            lanes[OUTPUT_BRISTLE_DAMPING + m] = plant.bristle_damping * (1.0 - share)
            lanes[BRISTLE + m] = state.bristle
            lanes[OUTPUT_BRISTLE + m] = state.output_bristle
        else:
            lanes[DRY + m] = dry
            lanes[BREAK_AWAY + m] = plant.motor_break_away + (plant.output_break_away if rigid else 0.0)
            lanes[OUTPUT_DRY + m] = plant.output_dry
            lanes[OUTPUT_BREAK_AWAY + m] = plant.output_break_away
        lanes[ANGLE + m] = state.motor_angle
        lanes[SPEED + m] = state.motor_speed
        lanes[OUTPUT_ANGLE + m] = state.output_angle
        lanes[OUTPUT_SPEED + m] = state.output_speed
        lanes[AMPERES + m] = state.current
        lanes[AMPERES_WANTED + m] = state.current_setpoint
        lanes[INTEGRAL + m] = state.integral
        lanes[SMOOTHED + m] = state.smoothed_speed


@njit(error_model="numpy")
def _bend(lanes, h, rigid):
    """Compute the bristles' torques in a step: before the shafts move, as in the kernel."""
    for m in range(LANE):
        lanes[BRISTLE + m], lanes[BENT + m] = bristle_step(
            lanes[BRISTLE + m], lanes[SPEED + m], lanes[LEVEL + m], lanes[BRISTLE_STIFFNESS + m],
            lanes[BRISTLE_DAMPING + m], h,
        )  # fmt: skip
        if not rigid:
            lanes[OUTPUT_BRISTLE + m], lanes[OUTPUT_BENT + m] = bristle_step(
                lanes[OUTPUT_BRISTLE + m], lanes[OUTPUT_SPEED + m], lanes[OUTPUT_LEVEL + m],
                lanes[OUTPUT_BRISTLE_STIFFNESS + m], lanes[OUTPUT_BRISTLE_DAMPING + m], h,
            )  # fmt: skip


@inlined
def _with_current(lanes, m):
    """Update the current towards its setpoint; returns the drive torque [N m] minus the bristle's."""
    change = lanes[CURRENT_GAIN + m] * (lanes[AMPERES_WANTED + m] - lanes[AMPERES + m])
    current = lanes[AMPERES + m] + change
    lanes[CHANGE + m] = change
    lanes[AMPERES + m] = current
    return lanes[TORQUE_CONSTANT + m] * current - lanes[BENT + m]


@inlined
def _with_motor(lanes, m, h, before, speed):
    """Advance a motor by a step."""
    lanes[SPEED_BEFORE + m] = before
    lanes[SPEED + m] = speed
    lanes[ANGLE + m] = lanes[ANGLE + m] + 0.5 * h * before + 0.5 * h * speed
    lanes[SMOOTHED + m] += lanes[SMOOTHING_GAIN + m] * (0.5 * (before + speed) - lanes[SMOOTHED + m])


@njit(error_model="numpy")
def _rigid_step(lanes, h, load):
    for m in range(LANE):
        torque = _with_current(lanes, m)
        before = lanes[SPEED + m]
        speed = shaft_speed(
            before, torque - load, lanes[DRY + m], lanes[BREAK_AWAY + m], lanes[GAIN + m], lanes[DRAG + m]
        )
        _with_motor(lanes, m, h, before, speed)


@njit(error_model="numpy")
def _two_inertia_step(lanes, h, load):
    for m in range(LANE):
        torque = _with_current(lanes, m)
        before = lanes[SPEED + m]
        output_before = lanes[OUTPUT_SPEED + m]
        shafts = Shafts(
            h, lanes[GAIN + m], lanes[DRAG + m], lanes[OUTPUT_GAIN + m], lanes[OUTPUT_DRAG + m], lanes[STIFFNESS + m],
            lanes[DAMPING + m], lanes[GAP + m], lanes[COMPLIANCE + m],
        )  # fmt: skip
        speed, output_speed, lanes[TRANSMITTED + m] = lumped_step(
            shafts, lanes[ANGLE + m] - lanes[OUTPUT_ANGLE + m], before, output_before, torque,
            load + lanes[OUTPUT_BENT + m], lanes[DRY + m], lanes[BREAK_AWAY + m], lanes[OUTPUT_DRY + m],
            lanes[OUTPUT_BREAK_AWAY + m],
        )  # fmt: skip
        _with_motor(lanes, m, h, before, speed)
        lanes[OUTPUT_SPEED + m] = output_speed
        lanes[OUTPUT_ANGLE + m] = lanes[OUTPUT_ANGLE + m] + 0.5 * h * output_before + 0.5 * h * output_speed


@njit(
    void(PLANTS, STATES, int64, STAMPS, types.Array(float64, 2, "C", readonly=True), float64[:, :, ::1], float64),
    cache=True,
    nogil=True,
    error_model="numpy",
)
def advance_many(plants, states, source, stamps, bench, twins, step):
    """As ``kernel.advance`` for ``plants`` and ``states`` (LANE,), filling ``twins`` (LANE, n, signals).

    All models have the same kind of transmission and control cycle, and either all or none have bristles. ``source`` is
    SETPOINT or CURRENT.
    """
    lanes = np.zeros(LANES)
    _load(plants, states, lanes)
    by_current = source == CURRENT
    rigid = plants[0].two_inertia == 0.0
    bristled = plants[0].bristle_stiffness > 0.0
    control_cycle = plants[0].control_cycle
    step = step_in_cycle(control_cycle, step)
    delayed = False
    for m in range(LANE):
        delayed = delayed or plants[m].encoder_delay > 0.0
    column = CURRENT_IN if by_current else SETPOINT_IN
    phase = states[0].control_phase
    setpoint = 0.0
    h = per_step = 0.0
    interval_before = int64(-1)
    steps = 1

    for row in range(1, stamps.shape[0]):
        nanoseconds = stamps[row] - stamps[row - 1]
        interval = nanoseconds * 1e-9
        if nanoseconds != interval_before:
            interval_before = nanoseconds
            steps = steps_in(interval, step)
            h = interval / steps
            per_step = 1.0 / h
            _settle(plants, lanes, h, by_current)
        start = bench[row - 1, column]
        slope = bench[row, column] - start
        load_start = bench[row - 1, LOAD_IN]
        load_slope = (bench[row, LOAD_IN] - load_start) / steps
        load = 0.0

        for k in range(steps):
            if by_current:
                given = start + slope * ((k + 0.5) / steps)
                for m in range(LANE):
                    lanes[AMPERES_WANTED + m] = given
            if phase >= control_cycle - 0.5 * h:
                phase -= control_cycle
                if delayed:
                    for m in range(LANE):
                        remember(states[m], lanes[(ANGLE if rigid else OUTPUT_ANGLE) + m])
                if not by_current:
                    setpoint = start + slope * (k / steps) + slope * (control_cycle / interval)
                    for m in range(LANE):
                        controller = Controller(
                            lanes[CONTROL_CYCLE + m], lanes[CURRENT_LIMIT + m], lanes[TORQUE_LIMIT + m],
                            lanes[NOMINAL_TORQUE_CONSTANT + m], lanes[SPEED_GAIN + m], lanes[INTEGRAL_TIME + m],
                            lanes[INTEGRAL_LIMIT + m], lanes[ANTI_WINDUP_TIME + m],
                        )  # fmt: skip
                        lanes[AMPERES_WANTED + m], lanes[INTEGRAL + m] = speed_controller(
                            controller, setpoint - lanes[SPEED + m], lanes[INTEGRAL + m], True
                        )
            phase += h

            load = load_start + load_slope * (k + 0.5)
            if bristled:
                _bend(lanes, h, rigid)
            if rigid:
                _rigid_step(lanes, h, load)
            else:
                _two_inertia_step(lanes, h, load)

        for m in range(LANE):
            plant = plants[m]
            state = states[m]
            speed = lanes[SPEED + m]
            current = lanes[AMPERES + m]
            angle = lanes[ANGLE + m]
            output_angle = angle if rigid else lanes[OUTPUT_ANGLE + m]
            transmitted = lanes[TRANSMITTED + m]
            acceleration = (speed - lanes[SPEED_BEFORE + m]) * per_step
            if rigid:
                transmitted = passed_rigidly(plant, acceleration, speed, load)
            at = Moment(
                phase=phase,
                angle=angle,
                speed=speed,
                acceleration=acceleration,
                output_angle=output_angle,
                smoothed_speed=lanes[SMOOTHED + m],
                speed_setpoint=setpoint,
                current=current,
                current_setpoint=lanes[AMPERES_WANTED + m],
                voltage=quadrature_voltage(plant, speed, current, lanes[CHANGE + m] * per_step),
                torque=plant.torque_constant * current,
                transmitted=transmitted,
            )
            write_row(twins[m, row], bench[row], by_current, plant, state, at)

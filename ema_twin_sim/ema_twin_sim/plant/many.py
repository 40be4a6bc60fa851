"""Several models of the averaged drive side by side: the kernel's own steps, with the model's number innermost.

A step of one model waits for the step before; steps of several do not wait for each other, and a processor's wide
registers take them together. Rigid and two-inertia transmissions whose effects have all settled into constants, under a
recorded speed setpoint or current (``simulation/simulate_many.py`` says which models those are). What the twin's
equations do not need is left out: the unexplained torque, which is a matter of measured motion alone.
"""

import math
from collections import namedtuple

import numpy as np
from numba import from_dtype, int64, njit, types, void

from .drive import lag_gain, quadrature_voltage, speed_controller
from .friction import bristle_share, bristle_step
from .layout import COMMAND_IN, CURRENT, CURRENT_IN, LOAD_IN, PLANT, SETPOINT_IN, STATE
from .sensors import counted, remember, shown
from .transmission import contact_torque, response, shaft_speed

LANE = 16
"""Models that go side by side: four registers of the usual widest kind, so that some work while others wait."""

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
"""What the speed controller reads of a plant (``drive.py``)."""

_ROWS = (
    *(name.upper() for name in Controller._fields),
    "TORQUE_CONSTANT",
    "CURRENT_GAIN",
    "SMOOTHING_GAIN",
    # each inertia's response to a step, and its dry friction
    "GAIN",
    "DRAG",
    "DRY",
    "BREAK_AWAY",
    "OUTPUT_GAIN",
    "OUTPUT_DRAG",
    "OUTPUT_DRY",
    "OUTPUT_BREAK_AWAY",
    # the contact
    "STIFFNESS",
    "DAMPING",
    "GAP",
    "COMPLIANCE",
    # each side's bristle, whose torque takes the place of dry friction
    "LEVEL",
    "BRISTLE_STIFFNESS",
    "BRISTLE_DAMPING",
    "OUTPUT_LEVEL",
    "OUTPUT_BRISTLE_STIFFNESS",
    "OUTPUT_BRISTLE_DAMPING",
    "BRISTLE",
    "OUTPUT_BRISTLE",
    "BENT",
    "OUTPUT_BENT",
    # state
    "ANGLE",
    "SPEED",
    "OUTPUT_ANGLE",
    "OUTPUT_SPEED",
    "CURRENT",
    "CURRENT_SETPOINT",
    "INTEGRAL",
    "SMOOTHED",
    # of the last step
    "SPEED_BEFORE",
    "CHANGE",
    "TRANSMITTED",
)
_AT = {name: LANE * k for k, name in enumerate(_ROWS)}
LANES = LANE * len(_ROWS)
CONTROL_CYCLE, CURRENT_LIMIT, TORQUE_LIMIT, NOMINAL = (
    _AT["CONTROL_CYCLE"],
    _AT["CURRENT_LIMIT"],
    _AT["TORQUE_LIMIT"],
    _AT["NOMINAL_TORQUE_CONSTANT"],
)
SPEED_GAIN, INTEGRAL_TIME, INTEGRAL_LIMIT = _AT["SPEED_GAIN"], _AT["INTEGRAL_TIME"], _AT["INTEGRAL_LIMIT"]
ANTI_WINDUP_TIME, TORQUE_CONSTANT = _AT["ANTI_WINDUP_TIME"], _AT["TORQUE_CONSTANT"]
CURRENT_GAIN, SMOOTHING_GAIN = _AT["CURRENT_GAIN"], _AT["SMOOTHING_GAIN"]
GAIN, DRAG, DRY, BREAK_AWAY = _AT["GAIN"], _AT["DRAG"], _AT["DRY"], _AT["BREAK_AWAY"]
OUTPUT_GAIN, OUTPUT_DRAG = _AT["OUTPUT_GAIN"], _AT["OUTPUT_DRAG"]
OUTPUT_DRY, OUTPUT_BREAK_AWAY = _AT["OUTPUT_DRY"], _AT["OUTPUT_BREAK_AWAY"]
STIFFNESS, DAMPING, GAP, COMPLIANCE = _AT["STIFFNESS"], _AT["DAMPING"], _AT["GAP"], _AT["COMPLIANCE"]
LEVEL, BRISTLE_STIFFNESS, BRISTLE_DAMPING = _AT["LEVEL"], _AT["BRISTLE_STIFFNESS"], _AT["BRISTLE_DAMPING"]
OUTPUT_LEVEL, OUTPUT_BRISTLE_STIFFNESS = _AT["OUTPUT_LEVEL"], _AT["OUTPUT_BRISTLE_STIFFNESS"]
OUTPUT_BRISTLE_DAMPING = _AT["OUTPUT_BRISTLE_DAMPING"]
BRISTLE, OUTPUT_BRISTLE, BENT, OUTPUT_BENT = _AT["BRISTLE"], _AT["OUTPUT_BRISTLE"], _AT["BENT"], _AT["OUTPUT_BENT"]
ANGLE, SPEED, OUTPUT_ANGLE, OUTPUT_SPEED = _AT["ANGLE"], _AT["SPEED"], _AT["OUTPUT_ANGLE"], _AT["OUTPUT_SPEED"]
AMPERES, AMPERES_WANTED = _AT["CURRENT"], _AT["CURRENT_SETPOINT"]
INTEGRAL, SMOOTHED = _AT["INTEGRAL"], _AT["SMOOTHED"]
SPEED_BEFORE, CHANGE, TRANSMITTED = _AT["SPEED_BEFORE"], _AT["CHANGE"], _AT["TRANSMITTED"]


@njit(error_model="numpy")
def _settle(plants, lanes, h, by_current):
    """What of the constants depends on the length of a step ``h`` [s]."""
    for m in range(LANE):
        plant = plants[m]
        rigid = plant.two_inertia == 0.0
        inertia = plant.motor_inertia + (plant.output_inertia if rigid else 0.0)
        viscous = plant.motor_viscous + (plant.output_viscous if rigid else 0.0)
        lanes[GAIN + m], lanes[DRAG + m] = response(h, inertia, viscous)
        lanes[OUTPUT_GAIN + m], lanes[OUTPUT_DRAG + m] = response(h, plant.output_inertia, plant.output_viscous)
        lanes[COMPLIANCE + m] = 0.5 * h * (1.0 / plant.motor_inertia + 1.0 / plant.output_inertia)
        lanes[CURRENT_GAIN + m] = 1.0 if by_current else lag_gain(h, plant.current_lag)
        lanes[SMOOTHING_GAIN + m] = lag_gain(h, plant.speed_smoothing)


@njit(error_model="numpy")
def _load(plants, states, lanes):
    """Constants and states of all models into their lanes."""
    for m in range(LANE):
        plant = plants[m]
        state = states[m]
        rigid = plant.two_inertia == 0.0
        lanes[CONTROL_CYCLE + m] = plant.control_cycle
        lanes[CURRENT_LIMIT + m] = plant.current_limit
        lanes[TORQUE_LIMIT + m] = plant.torque_limit
        lanes[NOMINAL + m] = plant.nominal_torque_constant
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
        lanes[STIFFNESS + m] = plant.contact_stiffness
        lanes[DAMPING + m] = plant.contact_damping
        lanes[GAP + m] = plant.gap
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
    """The bristles' torques in a step: before the shafts move, as in the kernel."""
    for m in range(LANE):
        lanes[BRISTLE + m], lanes[BENT + m] = bristle_step(
            lanes[BRISTLE + m],
            lanes[SPEED + m],
            lanes[LEVEL + m],
            lanes[BRISTLE_STIFFNESS + m],
            lanes[BRISTLE_DAMPING + m],
            h,
        )
        if not rigid:
            lanes[OUTPUT_BRISTLE + m], lanes[OUTPUT_BENT + m] = bristle_step(
                lanes[OUTPUT_BRISTLE + m],
                lanes[OUTPUT_SPEED + m],
                lanes[OUTPUT_LEVEL + m],
                lanes[OUTPUT_BRISTLE_STIFFNESS + m],
                lanes[OUTPUT_BRISTLE_DAMPING + m],
                h,
            )


@njit(error_model="numpy")
def _rigid_step(lanes, h, load):
    for m in range(LANE):
        change = lanes[CURRENT_GAIN + m] * (lanes[AMPERES_WANTED + m] - lanes[AMPERES + m])
        current = lanes[AMPERES + m] + change
        lanes[CHANGE + m] = change
        lanes[AMPERES + m] = current
        before = lanes[SPEED + m]
        speed = shaft_speed(
            before,
            lanes[TORQUE_CONSTANT + m] * current - lanes[BENT + m] - load,
            lanes[DRY + m],
            lanes[BREAK_AWAY + m],
            lanes[GAIN + m],
            lanes[DRAG + m],
        )
        lanes[SPEED_BEFORE + m] = before
        lanes[SPEED + m] = speed
        lanes[ANGLE + m] = lanes[ANGLE + m] + 0.5 * h * before + 0.5 * h * speed
        lanes[SMOOTHED + m] += lanes[SMOOTHING_GAIN + m] * (0.5 * (before + speed) - lanes[SMOOTHED + m])


@njit(error_model="numpy")
def _two_inertia_step(lanes, h, load):
    for m in range(LANE):
        change = lanes[CURRENT_GAIN + m] * (lanes[AMPERES_WANTED + m] - lanes[AMPERES + m])
        current = lanes[AMPERES + m] + change
        lanes[CHANGE + m] = change
        lanes[AMPERES + m] = current
        before = lanes[SPEED + m]
        output_before = lanes[OUTPUT_SPEED + m]
        transmitted = contact_torque(
            lanes[ANGLE + m] - lanes[OUTPUT_ANGLE + m],
            before - output_before,
            lanes[STIFFNESS + m],
            lanes[DAMPING + m],
            lanes[GAP + m],
            h,
            lanes[COMPLIANCE + m],
        )
        speed = shaft_speed(
            before,
            lanes[TORQUE_CONSTANT + m] * current - lanes[BENT + m] - transmitted,
            lanes[DRY + m],
            lanes[BREAK_AWAY + m],
            lanes[GAIN + m],
            lanes[DRAG + m],
        )
        output_speed = shaft_speed(
            output_before,
            transmitted - (load + lanes[OUTPUT_BENT + m]),
            lanes[OUTPUT_DRY + m],
            lanes[OUTPUT_BREAK_AWAY + m],
            lanes[OUTPUT_GAIN + m],
            lanes[OUTPUT_DRAG + m],
        )
        lanes[TRANSMITTED + m] = transmitted
        lanes[SPEED + m] = speed
        lanes[ANGLE + m] = lanes[ANGLE + m] + 0.5 * h * before + 0.5 * h * speed
        lanes[OUTPUT_SPEED + m] = output_speed
        lanes[OUTPUT_ANGLE + m] = lanes[OUTPUT_ANGLE + m] + 0.5 * h * output_before + 0.5 * h * output_speed
        lanes[SMOOTHED + m] += lanes[SMOOTHING_GAIN + m] * (0.5 * (before + speed) - lanes[SMOOTHED + m])


@njit(
    void(
        from_dtype(PLANT)[::1],
        from_dtype(STATE)[::1],
        int64,
        types.Array(int64, 1, "C", readonly=True),
        types.Array(types.float64, 2, "C", readonly=True),
        types.float64[:, :, ::1],
        types.float64,
    ),
    cache=True,
    nogil=True,
    error_model="numpy",
)
def advance_many(plants, states, source, stamps, bench, twins, step):
    """As ``kernel.advance``, of ``plants`` and ``states`` (LANE,), into ``twins`` (LANE, n, signals).

    All models have one kind of transmission and one control cycle, and all of them bristles or none. ``source`` is
    SETPOINT or CURRENT.
    """
    lanes = np.zeros(LANES)
    _load(plants, states, lanes)
    by_current = source == CURRENT
    rigid = plants[0].two_inertia == 0.0
    bristled = plants[0].bristle_stiffness > 0.0
    control_cycle = plants[0].control_cycle
    step = control_cycle / math.ceil(control_cycle / step - 1e-9)  # so that cycles begin on a step
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
            steps = max(1, math.ceil(interval / step - 1e-9))
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
                            lanes[CONTROL_CYCLE + m],
                            lanes[CURRENT_LIMIT + m],
                            lanes[TORQUE_LIMIT + m],
                            lanes[NOMINAL + m],
                            lanes[SPEED_GAIN + m],
                            lanes[INTEGRAL_TIME + m],
                            lanes[INTEGRAL_LIMIT + m],
                            lanes[ANTI_WINDUP_TIME + m],
                        )
                        demand, lanes[INTEGRAL + m] = speed_controller(
                            controller, setpoint - lanes[SPEED + m], lanes[INTEGRAL + m], True
                        )
                        lanes[AMPERES_WANTED + m] = demand / lanes[NOMINAL + m]
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
            if rigid:
                sense = 1.0 if speed > 0.0 else (-1.0 if speed < 0.0 else 0.0)
                acceleration = (speed - lanes[SPEED_BEFORE + m]) * per_step
                transmitted = (
                    plant.output_inertia * acceleration + plant.output_viscous * speed + plant.output_dry * sense + load
                )
            twin = twins[m, row]
            twin[0] = bench[row, CURRENT_IN] if by_current else current
            twin[1] = math.nan if by_current else lanes[AMPERES_WANTED + m]
            twin[2] = lanes[SMOOTHED + m]
            twin[3] = math.nan if by_current else setpoint
            twin[4] = counted(angle, plant.motor_counts)
            twin[5] = counted(shown(plant, state, output_angle, phase) - state.encoder_zero, plant.output_counts)
            twin[6] = bench[row, COMMAND_IN]
            twin[7] = quadrature_voltage(plant, speed, current, lanes[CHANGE + m] * per_step)
            twin[8] = plant.torque_constant * current
            twin[9] = transmitted
            twin[10:] = math.nan

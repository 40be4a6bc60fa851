"""The equation error of several models in parallel lanes, with the output behind backlash or compliance.

Same steps as ``inverse_dynamics`` (``measured_motion.py``), with the model index innermost: steps of one model depend
on each other, but a processor's wide registers compute several models together.
"""

import math

import numpy as np
from numba import float64, int64, njit, void

from .evaluate import evaluate
from .friction import bristle_share
from .measured_motion import MEETINGS, base_dry_level, operating_point, with_friction, with_load
from .motion import LOAD, MOTOR_ANGLE, SPEED, TIME
from .output_side import LOW_SPEED, OutputSide, first_output_angle, longest_substep, output_side, output_step, sign
from .signatures import PLANTS
from .time_steps import steps_in
from .transmission import response

LANE = 8
"""Number of parallel models: a search needs some ten at a time."""

LANES = 40 * LANE
"""Length of the flat array of lanes: the first quantity of all models comes first."""

(
    # output side, as the fields of OutputSide follow each other
    INERTIA,
    VISCOUS,
    DRY,
    GAP,
    ASYMMETRY,
    STIFFNESS,
    DAMPING,
    BRISTLE_STIFFNESS,
    BRISTLE_DAMPING,
    PULL,
    BRAKE,
    SUBSTEP,
    # motor side
    RATIO,
    VISCOUS_OF_MOTOR,
    MOTOR_DRY,
    STIFFNESS_OF_BRISTLE,
    DAMPING_OF_BRISTLE,
    # of an interval
    STEPS,
    H,
    GAIN,
    DRAG,
    COMPLIANCE,
    SLOPE,
    DRIFT,
    SEEN,
    SEEN_SPEED,
    # of a sample
    TORQUE,
    AGAINST,
    DRY_NOW,
    THINNED,
    CONTACT,
    PASSED,
    # state
    ANGLE,
    OUTPUT_ANGLE,
    OUTPUT_SPEED,
    OUTPUT_BRISTLE,
    BRISTLE,
    ZERO,
    MET,
    FIRST_MET,
) = range(0, LANES, LANE)


@njit(error_model="numpy")
def _load_lanes(plants, motion, seen, lanes):
    """Load constants and initial states of all models into their lanes."""
    for m in range(LANE):
        plant = plants[m]
        side = output_side(plant)
        for k in range(len(side)):
            lanes[k * LANE + m] = side[k]
        lanes[SUBSTEP + m] = longest_substep(side)
        lanes[RATIO + m] = plant.gear_ratio
        lanes[VISCOUS_OF_MOTOR + m] = plant.motor_viscous
        lanes[MOTOR_DRY + m] = base_dry_level(plant)
        share = bristle_share(plant)
        lanes[STIFFNESS_OF_BRISTLE + m] = plant.bristle_stiffness * share
        lanes[DAMPING_OF_BRISTLE + m] = plant.bristle_damping * share
        lanes[OUTPUT_ANGLE + m] = first_output_angle(side, motion, plant.gear_ratio, seen[:, m])
        lanes[OUTPUT_SPEED + m] = motion[0, SPEED]


@njit(error_model="numpy")
def _settle(lanes, interval):
    """Set what depends on the length of an interval [s]; returns the largest number of steps of any model."""
    most = 1.0
    for m in range(LANE):
        steps = steps_in(interval, lanes[SUBSTEP + m])
        h = interval / steps
        lanes[STEPS + m] = steps
        lanes[H + m] = h
        lanes[GAIN + m], lanes[DRAG + m] = response(h, lanes[INERTIA + m], lanes[VISCOUS + m])
        lanes[COMPLIANCE + m] = 0.5 * h / lanes[INERTIA + m]
        most = max(most, steps)
    return int64(most)


@njit(error_model="numpy")
def _output_steps(lanes, k, speed_before):
    """Step ``k`` of every output whose interval has so many steps."""
    for m in range(LANE):
        side = OutputSide(
            lanes[INERTIA + m], lanes[VISCOUS + m], lanes[DRY + m], lanes[GAP + m], lanes[ASYMMETRY + m],
            lanes[STIFFNESS + m], lanes[DAMPING + m], lanes[BRISTLE_STIFFNESS + m], lanes[BRISTLE_DAMPING + m],
            lanes[PULL + m], lanes[BRAKE + m],
        )  # fmt: skip
        h = lanes[H + m]
        motor_speed = speed_before + lanes[SLOPE + m] * (k + 0.5)
        seen = lanes[SEEN + m] - lanes[ZERO + m] + (k + 0.5) * h * lanes[SEEN_SPEED + m]
        contact, angle, speed, bristle = output_step(
            side, h, lanes[GAIN + m], lanes[DRAG + m], lanes[COMPLIANCE + m], lanes[ANGLE + m], motor_speed,
            lanes[OUTPUT_ANGLE + m], lanes[OUTPUT_SPEED + m], lanes[OUTPUT_BRISTLE + m], lanes[AGAINST + m],
            lanes[MET + m] > 0.0, seen, lanes[SEEN_SPEED + m],
        )  # fmt: skip
        going = k < lanes[STEPS + m]
        lanes[OUTPUT_ANGLE + m] = angle if going else lanes[OUTPUT_ANGLE + m]
        lanes[OUTPUT_SPEED + m] = speed if going else lanes[OUTPUT_SPEED + m]
        lanes[OUTPUT_BRISTLE + m] = bristle if going else lanes[OUTPUT_BRISTLE + m]
        lanes[ANGLE + m] += h * motor_speed + lanes[DRIFT + m]
        lanes[CONTACT + m] = contact if going else lanes[CONTACT + m]
        lanes[PASSED + m] += contact if going else 0.0


@njit(error_model="numpy")
def _drive(lanes, speed, bristled, interval, torque):
    """Fill the ``torque`` (LANE,) of every drive, without its output's share."""
    sense = sign(speed, LOW_SPEED)
    for m in range(LANE):
        torque[m], lanes[BRISTLE + m] = with_friction(
            lanes[TORQUE + m], 0.0, speed, sense, lanes[VISCOUS_OF_MOTOR + m], lanes[THINNED + m],
            lanes[ASYMMETRY + m], lanes[DRY_NOW + m], bristled, lanes[BRISTLE + m],
            lanes[STIFFNESS_OF_BRISTLE + m], lanes[DAMPING_OF_BRISTLE + m], interval,
        )  # fmt: skip


@njit(
    void(
        PLANTS,
        int64[::1],
        int64[::1],
        float64[:, :, ::1],
        float64[:, ::1],
        float64,
        float64,
        float64[:, ::1],
        float64[:, ::1],
        float64[:, ::1],
    ),
    cache=True,
    nogil=True,
    error_model="numpy",
)
def inverse_dynamics_many(
    plants, addresses, places, parameters, motion, motor_origin, output_origin, seen, torque, output
):
    """As ``inverse_dynamics`` for ``plants`` (LANE,) whose effects differ only in their ``parameters`` (LANE, k, 4).

    Fills ``torque`` (n, LANE) and ``output`` (n, LANE), the first two of ``REQUIRED``. ``seen`` is (n, LANE), or (0,
    LANE) if the output was not measured.
    """
    lanes = np.zeros(LANES)
    passed = np.zeros((motion.shape[0], LANE))
    _load_lanes(plants, motion, seen, lanes)
    drawn = seen.shape[0] == motion.shape[0]
    bristled = plants[0].bristle_stiffness > 0.0
    plain = addresses.shape[0] == 0  # then only a measured load acts
    for m in range(LANE):
        plain = plain and math.isinf(plants[m].end_stop_lower) and math.isinf(plants[m].end_stop_upper)
        lanes[DRY_NOW + m] = lanes[MOTOR_DRY + m]
    interval_before = -1.0
    most = 0
    for row in range(motion.shape[0]):
        speed = motion[row, SPEED]
        before = max(row - 1, 0)
        interval = motion[row, TIME] - motion[before, TIME]
        if plain:
            for m in range(LANE):
                lanes[AGAINST + m] = motion[row, LOAD]
        else:
            for m in range(LANE):
                plant = plants[m]
                at = operating_point(
                    plant, motion[row], motor_origin, output_origin, passed[before, m], lanes[MOTOR_DRY + m]
                )
                lanes[TORQUE + m], lanes[DRY_NOW + m], load, lanes[THINNED + m] = evaluate(
                    (addresses, places, parameters[m]), at
                )
                lanes[AGAINST + m] = with_load(load, plant, motion[row], output_origin)
        if row > 0:
            if interval != interval_before:
                interval_before = interval
                most = _settle(lanes, interval)
            angle = motion[before, MOTOR_ANGLE]
            speed_before = motion[before, SPEED]
            drift = motion[row, MOTOR_ANGLE] - angle - 0.5 * (speed + speed_before) * interval
            for m in range(LANE):
                lanes[ANGLE + m] = angle
                lanes[SLOPE + m] = (speed - speed_before) / lanes[STEPS + m]
                lanes[DRIFT + m] = drift / lanes[STEPS + m]
                lanes[PASSED + m] = 0.0
            if drawn:
                for m in range(LANE):
                    lanes[SEEN + m] = seen[before, m] * lanes[RATIO + m]
                    lanes[SEEN_SPEED + m] = (seen[row, m] - seen[before, m]) * lanes[RATIO + m] / interval
            for k in range(most):
                _output_steps(lanes, k, speed_before)
            for m in range(LANE):
                passed[row, m] = lanes[PASSED + m] / lanes[STEPS + m]
            if drawn:
                for m in range(LANE):
                    met = lanes[MET + m] + (1.0 if lanes[CONTACT + m] != 0.0 else 0.0)
                    lanes[FIRST_MET + m] = float(row) if lanes[MET + m] == 0.0 and met > 0.0 else lanes[FIRST_MET + m]
                    away = seen[row, m] * lanes[RATIO + m] - lanes[OUTPUT_ANGLE + m] - lanes[ZERO + m]
                    lanes[ZERO + m] += away / min(met, MEETINGS) if lanes[CONTACT + m] != 0.0 else 0.0
                    lanes[MET + m] = met
        if bristled:
            _drive(lanes, speed, True, interval, torque[row])
        else:
            _drive(lanes, speed, False, interval, torque[row])
        for m in range(LANE):
            output[row, m] = lanes[OUTPUT_ANGLE + m] / lanes[RATIO + m]
    for m in range(LANE):
        for row in range(int64(lanes[FIRST_MET + m])):
            output[row, m] = seen[row, m] - lanes[ZERO + m] / lanes[RATIO + m]
    last = motion.shape[0] - 1
    for row in range(last + 1):
        for m in range(LANE):
            torque[row, m] += 0.5 * (passed[row, m] + passed[min(row + 1, last), m])

"""Sensors: a late or eccentric encoder, detected in the encoder difference together with backlash or compliance.

Backlash follows the direction of the transmitted torque, compliance its size, a delay the speed, an eccentricity the
output angle. One robust regression separates them before any gearbox is simulated.
"""

from __future__ import annotations

import math

import numpy as np

from ..criteria import BESIDE_IMPACTS, CORRELATION, DEPENDS, INTERPOLATED, MOSTLY, PART, SMALL
from ..effects import catalogue
from ..model.roles import SENSOR_DELAY, SENSOR_WAVE
from ..plant.measured_motion import REQUIRED
from ..plant.motion import OUTPUT_ANGLE, SPEED
from .candidates import addable
from .comparable import by_chance
from .equation import EquationErrorProblem
from .fit import Fit
from .hypothesis import Hypothesis

GEARBOX_COLUMNS = 3  # tooth flank in contact, transmitted torque, direction of motion
STEPS = 20
NEXT_TO_NOTHING = 0.01  # in units of the misfit; an effect must lower it by several units


def with_sensors(problem: EquationErrorProblem, f: Fit, without: frozenset[str] = frozenset()) -> Hypothesis:
    """The hypothesis of a fit with encoder delay and eccentricity added, each if the encoder difference shows it.

    Effects in ``without`` are not added, and values are clipped to the search bounds: with wide backlash the regressed
    delay may be longer than a plant can have.
    """
    torque, sensors = _columns(problem, f)
    wanted = _unexplained(problem, f)
    h = f.hypothesis
    held = {*h.effects} | without
    _, bare = _regress(torque, wanted)
    for effect, columns in sensors.items():
        if effect in held or not addable(h, effect):
            continue
        coefficients, cost = _regress(np.concatenate([torque, columns], axis=1), wanted)
        if cost > (1.0 - PART) * bare:
            continue
        own = coefficients[torque.shape[1] :]
        if effect == SENSOR_DELAY and own[0] > 0.0:
            h = h.with_effect(effect, {}, {"delay": float(own[0])})
        elif effect == SENSOR_WAVE and own.any():
            parameters = {"amplitude": math.hypot(*own), "phase": math.atan2(own[1], own[0])}
            h = h.with_effect(effect, catalogue()[effect].default_options(), parameters)
    return h.at(np.clip(h.values, *problem.bounds(h)))


def gearbox_shows(problem: EquationErrorProblem, f: Fit) -> bool:
    """Whether backlash or compliance may cause the encoder difference: by torque, tooth flank or direction.

    It must explain a share of the difference alone, and of what a late or eccentric encoder leaves. This is skipped if
    what is left exceeds interpolation error: an output that flies through a wide gap follows neither torque nor
    direction. The regression takes milliseconds; trying every gearbox would take seconds.
    """
    if not problem.size:
        return True
    gearbox, sensors = _columns(problem, f)
    wanted = problem.measured[problem.size :]
    for others in (gearbox[:, GEARBOX_COLUMNS:], np.concatenate([gearbox[:, GEARBOX_COLUMNS:], *sensors.values()], 1)):
        (_, bare), (_, beside) = (
            _regress(columns, wanted) for columns in (others, np.concatenate([gearbox[:, :GEARBOX_COLUMNS], others], 1))
        )
        if bare > _misfit(np.full(len(wanted), INTERPOLATED)):
            continue
        # if sensors explain it down to the noise, nothing is left to take a share of
        if bare - beside <= max(SMALL * (bare - len(wanted)), CORRELATION * by_chance(GEARBOX_COLUMNS)):
            return False
    return True


def hysteresis(problem: EquationErrorProblem, f: Fit) -> float:
    """Encoder difference [rad, slow shaft] between the two directions, with sensor errors regressed out."""
    gearbox, sensors = _columns(problem, f)
    by_direction = gearbox[:, GEARBOX_COLUMNS - 1 :]
    coefficients, _ = _regress(np.concatenate([by_direction, *sensors.values()], 1), _unexplained(problem, f))
    return 2.0 * abs(float(coefficients[0]))


def delay_shows(problem: EquationErrorProblem, f: Fit) -> bool:
    """Whether an encoder delay shows in the presence of everything a gearbox may show instead."""
    alone, beside_gearbox = delay_beside_gearbox(problem, f)
    return beside_gearbox > max(DEPENDS, SMALL * alone)


def delay_of_gearbox(problem: EquationErrorProblem, f: Fit) -> bool:
    """Whether most of a regressed encoder delay is what a gearbox that gives way shows: by torque, flank or direction.

    A true delay keeps its value beside these. An output that lags by the same angle at any speed does not lag by a
    time: in a regression on the delay alone it appears as one, of a value that changes with the speeds recorded.
    """
    gearbox, sensors = _columns(problem, f)
    wanted = _unexplained(problem, f)
    delay = sensors[SENSOR_DELAY]
    alone, _ = _regress(np.concatenate([delay, gearbox[:, GEARBOX_COLUMNS:]], axis=1), wanted)
    beside, _ = _regress(np.concatenate([delay, gearbox, sensors[SENSOR_WAVE]], axis=1), wanted)
    return bool(beside[0] < MOSTLY * alone[0])


def delay_beside_gearbox(problem: EquationErrorProblem, f: Fit) -> tuple[float, float]:
    """Gain of an encoder delay (alone, together with all else): decrease of Cauchy misfit over the remaining noise.

    With compliance or backlash, the output lags more the faster it turns, because friction grows with speed; a
    regression on delay alone takes that for a delay. With the transmitted torque and its direction included, nothing of
    that look-alike remains, while part of a true delay does.
    """
    gearbox, sensors = _columns(problem, f)
    wanted = _unexplained(problem, f)
    delay = sensors[SENSOR_DELAY]
    gains = []
    for others in (gearbox[:, GEARBOX_COLUMNS:], np.concatenate([gearbox, sensors[SENSOR_WAVE]], axis=1)):
        _, bare = _regress(others, wanted)
        _, beside = _regress(np.concatenate([delay, others], axis=1), wanted)
        gains.append((bare - beside) / (CORRELATION * max(1.0, beside / len(wanted))))
    return gains[0], gains[1]


def _unexplained(problem: EquationErrorProblem, f: Fit) -> np.ndarray:
    """Encoder difference (k,) in units of noise; without torque data, minus the prediction of a fit."""
    apart = problem.measured[problem.size :]
    return apart if problem.size else apart - f.predicted.rows


def _columns(problem: EquationErrorProblem, f: Fit) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """(gearbox columns (k, c), columns of each sensor error (k, 1 or 2)) at all encoder rows, in units of noise."""
    ratio = f.predicted.plant["gear_ratio"][0]
    transmitted, speed, angle = [], [], []
    for o, required in zip(problem.observations, f.predicted.required_by_recording, strict=True):
        at = o.encoder_rows
        transmitted.append(required[at, REQUIRED.index("transmitted")])
        speed.append(o.motion[at, SPEED] / ratio)
        angle.append(o.output_origin + o.motion[at, OUTPUT_ANGLE])
    noise = problem.encoder_noise[:, None]
    passed = np.concatenate(transmitted)[:, None]
    moving = np.concatenate(speed)[:, None]
    pieces = np.zeros((len(noise), len(problem.encoder_pieces)))
    for k, (first, end) in enumerate(problem.encoder_pieces - problem.size):
        pieces[first:end, k] = 1.0
    theta = np.concatenate(angle)
    waves = np.stack([np.sin(theta), np.cos(theta)], axis=1)
    return (
        # if the model's friction is all at the motor, only the speed shows which flank is in contact
        np.concatenate([np.sign(passed), passed, np.sign(moving), pieces], axis=1) / noise,
        {
            SENSOR_WAVE: waves / noise,
            SENSOR_DELAY: -moving / noise,
        },
    )


def _regress(columns: np.ndarray, wanted: np.ndarray) -> tuple[np.ndarray, float]:
    """(coefficients (c,), Cauchy misfit) by iteratively reweighted least squares, which limits the effect of outliers.

    Each step lowers the misfit; it stops when a step lowers it by less than ``NEXT_TO_NOTHING``.
    """
    sizes = np.maximum(np.linalg.norm(columns, axis=0), 1e-30)
    columns = columns / sizes
    weights = np.ones(len(wanted))
    misfit = math.inf
    for _ in range(STEPS):
        weighted = columns * weights[:, None]
        # Normal equations are an order of magnitude faster than an SVD, and safe for columns of equal norm.
        coefficients = np.linalg.lstsq(weighted.T @ columns, weighted.T @ wanted, rcond=1e-12)[0]
        left = wanted - columns @ coefficients
        before, misfit = misfit, _misfit(left)
        if before - misfit < NEXT_TO_NOTHING:
            break
        weights = 1.0 / (1.0 + (left / BESIDE_IMPACTS) ** 2)
    return coefficients / sizes, misfit


def _misfit(left: np.ndarray) -> float:
    """Cauchy misfit of rows (k,), in units of noise."""
    return float(BESIDE_IMPACTS**2 * np.log1p((left / BESIDE_IMPACTS) ** 2).sum())

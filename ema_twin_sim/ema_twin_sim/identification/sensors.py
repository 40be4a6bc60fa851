"""Sensors: an encoder that is late or off its centre, seen in the encoders' difference beside a play or spring.

A gap's jumps follow the transmitted torque's direction, a spring's give its size, a delay the speed, an eccentricity
the output's angle: one robust regression tells them apart before any gearbox is simulated.
"""

from __future__ import annotations

import math

import numpy as np

from ..criteria import BESIDE_IMPACTS, CORRELATION, DEPENDS, INTERPOLATED, PART, SMALL
from ..effects import catalogue
from ..model.roles import SENSOR_DELAY, SENSOR_WAVE
from ..plant.measured_motion import OUTPUT_ANGLE, REQUIRED, SPEED
from .candidates import no_more_of
from .comparable import by_chance
from .equation import EquationErrorProblem
from .fit import Fit
from .hypothesis import Hypothesis

GEARBOX_COLUMNS = 3  # the tooth touched, the torque, the direction
STEPS = 20
NEXT_TO_NOTHING = 0.01  # of a misfit, in which an effect must gain several units


def with_sensors(problem: EquationErrorProblem, f: Fit, without: frozenset[str] = frozenset()) -> Hypothesis:
    """A fit's hypothesis with the encoder's delay and eccentricity, each where the encoders' difference shows it.

    Not with what is ruled out (``without``), and no farther than the search may go: beside wide play a regression's
    delay may be longer than any that a plant can show.
    """
    torque, sensors = _columns(problem, f)
    wanted = _unexplained(problem, f)
    h = f.hypothesis
    held = {*h.effects} | no_more_of(h) | without
    _, bare = _regress(torque, wanted)
    for effect, columns in sensors.items():
        if effect in held:
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
    """Whether play or a spring could be behind how the encoders part: by the torque, the tooth, or the direction.

    It must explain a share of that by itself, and of what an encoder that is late or off its centre leaves; unless this
    is more than an encoder errs by between its lines. An output that flies through a wide gap follows neither the
    torque nor the direction. A regression answers in milliseconds what trying every gearbox would take seconds to
    answer.
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
        # where sensors explain it to the noise, nothing is left to take a share of
        if bare - beside <= max(SMALL * (bare - len(wanted)), CORRELATION * by_chance(GEARBOX_COLUMNS)):
            return False
    return True


def hysteresis(problem: EquationErrorProblem, f: Fit) -> float:
    """How far [rad, slow shaft] the encoders part from one direction to the other, beside their sensors' errors."""
    gearbox, sensors = _columns(problem, f)
    by_direction = gearbox[:, GEARBOX_COLUMNS - 1 :]
    coefficients, _ = _regress(np.concatenate([by_direction, *sensors.values()], 1), _unexplained(problem, f))
    return 2.0 * abs(float(coefficients[0]))


def delay_shows(problem: EquationErrorProblem, f: Fit) -> bool:
    """Whether an encoder's delay shows beside all that a gearbox may show in its place."""
    alone, beside_gearbox = delay_beside_gearbox(problem, f)
    return beside_gearbox > max(DEPENDS, SMALL * alone)


def delay_beside_gearbox(problem: EquationErrorProblem, f: Fit) -> tuple[float, float]:
    """(gain alone, gain beside all else) of an encoder's delay, in Cauchy's misfit over twice what is left a row.

    A gearbox that winds up, or whose teeth part, lets the output lag behind the more the faster it turns, since
    friction grows with speed: to a delay alone it is one. Beside the transmitted torque and its direction nothing is
    left of that likeness, while of a true delay a part is that no torque explains.
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
    """How far (k,) the encoders part, in units of noise; where no torque was measured, beside what a fit has for it."""
    apart = problem.measured[problem.size :]
    return apart if problem.size else apart - f.predicted.rows


def _columns(problem: EquationErrorProblem, f: Fit) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """(what a gearbox shows (k, c), what each sensor shows (k, 1 or 2)) at all encoder rows, in units of noise."""
    ratio = f.predicted.plant["gear_ratio"][0]
    transmitted, speed, angle = [], [], []
    for o, required in zip(problem.observations, f.predicted.required, strict=True):
        at = o.encoder_rows
        transmitted.append(required[at, REQUIRED.index("transmitted")])
        speed.append(o.motion[at, SPEED] / ratio)
        angle.append(o.output_origin + o.motion[at, OUTPUT_ANGLE])
    noise = problem.encoder_noise[:, None]
    passed = np.concatenate(transmitted)[:, None]
    moving = np.concatenate(speed)[:, None]
    pieces = np.zeros((len(noise), len(problem.encoder_pieces)))
    for k, piece in enumerate(problem.encoder_pieces):
        pieces[piece.start - problem.size : piece.stop - problem.size, k] = 1.0
    theta = np.concatenate(angle)
    waves = np.stack([np.sin(theta), np.cos(theta)], axis=1)
    return (
        # where the model's friction is all at the motor, only the speed tells which tooth is touched
        np.concatenate([np.sign(passed), passed, np.sign(moving), pieces], axis=1) / noise,
        {
            SENSOR_WAVE: waves / noise,
            SENSOR_DELAY: -moving / noise,
        },
    )


def _regress(columns: np.ndarray, wanted: np.ndarray) -> tuple[np.ndarray, float]:
    """(coefficients (c,), Cauchy's misfit): iteratively reweighted least squares, outliers weighted down.

    Each step lowers the misfit; they end once one lowers it by next to nothing.
    """
    sizes = np.maximum(np.linalg.norm(columns, axis=0), 1e-30)
    columns = columns / sizes
    weights = np.ones(len(wanted))
    misfit = math.inf
    for _ in range(STEPS):
        weighted = columns * weights[:, None]
        # normal equations: of columns of one size, an order quicker than a decomposition of them
        coefficients = np.linalg.lstsq(weighted.T @ columns, weighted.T @ wanted, rcond=1e-12)[0]
        left = wanted - columns @ coefficients
        before, misfit = misfit, _misfit(left)
        if before - misfit < NEXT_TO_NOTHING:
            break
        weights = 1.0 / (1.0 + (left / BESIDE_IMPACTS) ** 2)
    return coefficients / sizes, misfit


def _misfit(left: np.ndarray) -> float:
    """Cauchy's misfit of rows (k,), in units of noise."""
    return float(BESIDE_IMPACTS**2 * np.log1p((left / BESIDE_IMPACTS) ** 2).sum())

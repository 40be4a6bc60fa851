"""Explained: whether nothing is left that the sensors' noise does not account for, by an explanation to believe."""

from __future__ import annotations

import numpy as np

from ...criteria import (
    APART,
    BRISTLED,
    DEPENDS,
    FAR_OFF_ROW,
    FAR_OUT,
    INTERPOLATED,
    LEAST_SIZE,
    MISFIT_DOUBTED,
    MISFIT_LEFT,
    NEGLIGIBLE,
    PART,
    SHAKY,
    SMALL,
    STANDSTILL,
    UNEXPLAINED,
)
from ...identification.equation import EquationErrorProblem
from ...identification.fit import Fit
from ...identification.generic_bases import beside_generic_bases, dependence, fit_with_basis
from ...identification.screening import screen_generic_bases
from ...plant.measured_motion import SPEED
from .plausible import only_constants, strained
from .worth import largest_rms_reduction, left_over


def explained(problem: EquationErrorProblem, f: Fit, start: Fit) -> bool:
    """Whether an end of a search, begun at ``start``, explains the recordings, and is plausible."""
    if f.hypothesis.base.is_open:
        return _nearly(problem, f) and not apart(problem, f, start)
    return not (unexplained(problem, f, start) or apart(problem, f, start) or strained(f) or only_constants(problem, f))


def _nearly(problem: EquationErrorProblem, f: Fit) -> bool:
    """Whether what is left of the torque is small beside it: all that can be asked where no constant is known.

    There neither the sensors' noise nor what a law of friction leaves of a real machine is known beforehand. Not asked
    of the few rows in which it stops or breaks away: there no friction slides.
    """
    slides = np.concatenate(
        [o.of_points | (np.abs(o.motion[o.rows, SPEED]) >= STANDSTILL) for o in problem.observations]
    )
    left = f.raw[: problem.size][slides] * problem.noise[slides]
    return float(np.sum(left**2)) <= SMALL**2 * float(np.sum(problem.torque[slides] ** 2))


def apart(problem: EquationErrorProblem, f: Fit, start: Fit) -> bool:
    """Whether some recording's encoders still part by far more than their noise, and than a large play excuses.

    And whether the output has lagged behind since the start, which nothing but play and springs lets it: a fit leaves
    the encoders' zeros open, and in one direction no more than that shows.
    """
    before = problem.residual(start.predicted)[problem.size :]
    parted = float(np.sqrt(np.mean(before**2))) if len(before) else 0.0
    if f.hypothesis.base.is_open:  # as with the torque: no more can be asked than that little is left
        return len(before) > 0 and float(np.sqrt(np.mean(f.raw[problem.size :] ** 2))) > max(PART * parted, APART)
    if lagging(problem, f):
        return True
    usual = min(APART, 1.0 + LEAST_SIZE * parted) if f.parted else INTERPOLATED
    allowed = min(max(usual, NEGLIGIBLE * parted), 0.5 * FAR_OFF_ROW)
    parts = [np.minimum(np.abs(f.raw[part]), FAR_OFF_ROW) for part in problem.encoder_parts if part.stop > part.start]
    return any(float(np.sqrt(np.mean(rows**2))) > allowed for rows in parts)


def lagging(problem: EquationErrorProblem, f: Fit) -> dict[str, float]:
    """By recording, how far [rad, slow shaft] its output lies off the motor since the first sample, beyond its noise.

    Nothing beside play or a spring, where it may begin anywhere, nor of a machine whose encoders are not known.
    """
    found: dict[str, float] = {}
    if f.parted or f.hypothesis.base.is_open:
        return found
    for o, part in zip(problem.observations, problem.encoder_parts, strict=True):
        first = o.encoder_piece == o.encoder_piece[0] if len(o.encoder_rows) else np.zeros(0, bool)
        if first.any():
            off = float(np.median((problem.measured - f.predicted.rows)[part][first] * o.encoder_noise[first]))
            reading = float(o.encoder_noise.min()) / float(np.linalg.norm(o.kernel))
            if abs(off) > FAR_OUT * reading:
                found[o.name] = off
    return found


def depends(problem: EquationErrorProblem, f: Fit) -> bool:
    """Whether what is left depends on anything.

    The load is what a fit makes of it, by laws of friction that no machine follows to a per cent: what follows it must
    be of a size that is worth a name, too.
    """
    beside = beside_generic_bases(problem, f)
    telling = [name for gained, name in screen_generic_bases(beside, f) if gained > DEPENDS]
    return any(dependence(name) != "load" or _worth_a_name(beside, f, name) for name in telling)


def _worth_a_name(problem: EquationErrorProblem, f: Fit, basis: str) -> bool:
    """Whether a generic basis takes as much from some recording's rows as an effect must."""
    return largest_rms_reduction(problem, f, fit_with_basis(problem, f, basis)) >= LEAST_SIZE


def coarse(problem: EquationErrorProblem) -> bool:
    """Whether a current's steps are wide beside its noise: slow motion rounds alike for a while, which is no chance."""
    return any(o.coarse for o in problem.observations if len(o.rows))


def unexplained(problem: EquationErrorProblem, f: Fit, start: Fit) -> bool:
    """Whether more is left over than the sensors' noise lets expect, of a recording or of moments of all.

    Where effects were added, it is always asked whether what is left depends on anything, however little that is: a
    likeness of the true effect may leave less than the noise, but what it leaves has the shape of that. Not asked of a
    coarse current, whose rounding has a shape too.
    """
    bristled = f.predicted.plant["bristle_stiffness"][0] > 0.0
    if not f.parted and problem.size:
        misfit = float(problem.costs(f.raw)[: problem.size].mean()) / (BRISTLED if bristled else 1.0)
        told_by_shape = bool(f.hypothesis.added) and not coarse(problem)
        if misfit > MISFIT_LEFT or ((misfit > MISFIT_DOUBTED or told_by_shape) and depends(problem, f)):
            return True
    for o, left, before in zip(problem.observations, left_over(problem, f), left_over(problem, start), strict=True):
        if not len(o.rows):
            continue
        allowed = UNEXPLAINED * float(np.median(o.torque_noise))
        if bristled:
            allowed *= BRISTLED
        if f.parted:
            allowed = max(SHAKY * allowed, PART * before)
        if left > allowed and (f.parted or left > 2.0 * allowed or depends(problem, f)):
            return True
    return False

"""Explained: whether the residual is within the sensors' noise, and the explanation is plausible."""

from __future__ import annotations

import math
from functools import cache

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
from ...plant.motion import SPEED
from .plausible import only_constants, strained
from .worth import largest_rms_reduction, left_over


def explained(problem: EquationErrorProblem, f: Fit, start: Fit) -> bool:
    """Whether the end of a search that began at ``start`` explains the recordings and is plausible."""
    if f.hypothesis.base.is_open:
        return _nearly(problem, f) and not apart(problem, f, start)
    return not (unexplained(problem, f, start) or apart(problem, f, start) or strained(f) or only_constants(problem, f))


def _nearly(problem: EquationErrorProblem, f: Fit) -> bool:
    """Whether the remaining torque, beyond the sensors' noise, is small: the only test if no constant is known.

    Then the error of a friction law on a real machine is not known beforehand. The few rows in which the machine stops
    or breaks away are left out, because friction does not slide there.
    """
    slides = np.concatenate(
        [o.of_points | (np.abs(o.motion[o.rows, SPEED]) >= STANDSTILL) for o in problem.observations]
    )
    plant = f.predicted.plant
    inertia = float(plant["motor_inertia"][0] + plant["output_inertia"][0])
    left = f.raw[: problem.size] * problem.noise
    beyond = 0.0
    for o, rows in zip(problem.observations, problem.torque_parts, strict=True):
        here = left[rows][slides[rows]]
        # in most rows the model's inertia acts on the noise, not the one found
        read = math.hypot(o.torque_reading, min(inertia, o.inertia) * o.acceleration_noise)
        beyond += max(float(here @ here) - read**2 * len(here), 0.0)
    return beyond <= SMALL**2 * float(np.sum(problem.torque[slides] ** 2))


def apart(problem: EquationErrorProblem, f: Fit, start: Fit) -> bool:
    """Whether the encoder difference of any recording is far above its noise, and above what large backlash may leave.

    Also whether the output has lagged since the start, which only backlash and compliance can cause. A fit leaves the
    encoders' zeros free, and with motion in one direction nothing else shows.
    """
    before = problem.residual(start.predicted)[problem.size :]
    parted = float(np.sqrt(np.mean(before**2))) if len(before) else 0.0
    if f.hypothesis.base.is_open:  # as for the torque: the only test is that little is left
        return len(before) > 0 and float(np.sqrt(np.mean(f.raw[problem.size :] ** 2))) > max(PART * parted, APART)
    if lagging(problem, f):
        return True
    usual = min(APART, 1.0 + LEAST_SIZE * parted) if f.parted else INTERPOLATED
    allowed = min(max(usual, NEGLIGIBLE * parted), 0.5 * FAR_OFF_ROW)
    parts = [np.minimum(np.abs(f.raw[part]), FAR_OFF_ROW) for part in problem.encoder_parts if part.stop > part.start]
    return any(float(np.sqrt(np.mean(rows**2))) > allowed for rows in parts)


def lagging(problem: EquationErrorProblem, f: Fit) -> dict[str, float]:
    """By recording: how far [rad, slow shaft] the output has been off the motor since the first sample, beyond noise.

    Empty if the model has backlash or compliance: then the output may start anywhere in the gap. Also empty for a
    machine with open constants, whose encoders are not known.
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
    """Whether the residual depends on anything.

    The load is computed by the fit, from friction laws that no machine follows to 1 %. So a dependence on the load must
    also be large enough to be named.
    """
    beside = beside_generic_bases(problem, f)
    telling = [name for gained, name in screen_generic_bases(beside, f) if gained > DEPENDS]
    return any(dependence(name) != "load" or _worth_a_name(beside, f, name) for name in telling)


def _worth_a_name(problem: EquationErrorProblem, f: Fit, basis: str) -> bool:
    """Whether a generic basis removes as much from some recording's rows as an effect must."""
    return largest_rms_reduction(problem, f, fit_with_basis(problem, f, basis)) >= LEAST_SIZE


def coarse(problem: EquationErrorProblem) -> bool:
    """Whether current steps are wide relative to the noise; in slow motion the rounding is then not random."""
    return any(o.coarse for o in problem.observations if len(o.rows))


def unexplained(problem: EquationErrorProblem, f: Fit, start: Fit) -> bool:
    """Whether the residual exceeds what the sensors' noise allows, in a recording or over all.

    If effects were added, the residual is always tested for a dependence, however small it is: a look-alike of the true
    effect may leave less than the noise, but what it leaves has the shape of the true one. This is skipped for a coarse
    current, whose rounding has a shape as well.
    """
    bristled = f.predicted.plant["bristle_stiffness"][0] > 0.0
    has_shape = cache(lambda: depends(problem, f))  # takes long, and is the same for all recordings
    if not f.parted and problem.size:
        misfit = float(problem.costs(f.raw)[: problem.size].mean()) / (BRISTLED if bristled else 1.0)
        told_by_shape = bool(f.hypothesis.added) and not coarse(problem)
        if misfit > MISFIT_LEFT or ((misfit > MISFIT_DOUBTED or told_by_shape) and has_shape()):
            return True
    for o, left, before in zip(problem.observations, left_over(problem, f), left_over(problem, start), strict=True):
        if not len(o.rows):
            continue
        allowed = UNEXPLAINED * float(np.median(o.torque_noise))
        if bristled:
            allowed *= BRISTLED
        if f.parted:
            allowed = max(SHAKY * allowed, PART * before)
        if left > allowed and (f.parted or left > 2.0 * allowed or has_shape()):
            return True
    return False

"""Disturbance: the effort that a place requires, without what control and inertia add because of the position error.

A controller answers a position error with effort, and acceleration takes effort. So much of the scatter of the effort
may follow the errors of the neighbouring samples and say nothing about the place. This dependence is fitted to the
scatter about the wave, and what the errors explain is subtracted, from the wave too: a disturbance observer whose model
is the stroke itself.

If the effort is nothing but the controller's answer, the torque of a place reaches it through the error alone, and
would be subtracted as well. The healthy wave takes the same path as the wave of a damage at the same wavelength. So how
much of the healthy wave is left shows whether waves may be freed of errors at all.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..criteria import CONTRADICTED, FEWEST_ROWS, MOSTLY, NEGLIGIBLE
from .motion_record import MotionRecord
from .wave import beside_wave

_TAPS = 2  # number of errors before and after
_TAPS_A_WAVE = 4  # errors a quarter wave before and after can follow any phase, those half a wave away any trend


def disturbance(
    record: MotionRecord, effort: np.ndarray, rows: np.ndarray, place: np.ndarray, wavelength: float
) -> tuple[np.ndarray, np.ndarray]:
    """(effort (m,) without what the position error explains, place (m,)) for those of the rows (n,) with neighbours.

    ``effort`` and ``place`` are those of the whole record. Without a command there is no position error, and too few
    rows do not show what it explains: then the effort is unchanged.
    """
    if record.command is None:
        return effort[rows], place[rows]
    step = max(1, int(len(rows) * wavelength / max(float(np.ptp(place[rows])), 1e-12) / _TAPS_A_WAVE))
    reach = (_TAPS + 1) * step
    shifts = range(-_TAPS * step, _TAPS * step + 1, step)
    inside = rows[(rows >= reach) & (rows < len(effort) - reach)]
    if len(inside) < FEWEST_ROWS + len(shifts):
        return effort[rows], place[rows]
    error = record.command - record.position
    # Averages over a step keep the scatter near the wave's own frequency, where the errors have to explain it.
    mean = np.full(step, 1.0 / step)
    slow = np.convolve(error, mean, "same")
    values, where = effort[inside], place[inside]
    errors = np.column_stack([slow[inside + shift] for shift in shifts])
    scatter = beside_wave(errors, where, wavelength)
    squares = scatter.T @ scatter
    # If errors hardly scatter except in the wave itself, they do not show which part of the effort they cause.
    floor = NEGLIGIBLE**2 * np.trace(beside_wave(errors, where, np.inf).T @ errors) / len(shifts)
    if not floor > 0.0:
        return values, where
    asked = beside_wave(np.convolve(effort, mean, "same")[inside], where, wavelength)
    shares = np.linalg.solve(squares + floor * np.eye(len(shifts)), scatter.T @ asked)
    return values - np.column_stack([error[inside + shift] for shift in shifts]) @ shares, where


def tells_more(plain: np.ndarray, freed: np.ndarray, tests: Sequence[str]) -> bool:
    """Whether waves freed of errors (n, k) show local damage better than plain ones (n, k), judged by healthy runs.

    They do if the healthy wave is known, most of it (MOSTLY) is left, and that is larger relative to its scatter from
    run to run. The k numbers are components of phasors, the same in both.
    """
    labels = np.asarray(tests)
    means = np.array([plain[labels == test].mean(axis=0) for test in dict.fromkeys(tests)])
    if len(means) < 2:
        return False
    error = float(np.sqrt(np.sum(means.var(axis=0, ddof=1)) / len(means)))
    before, left = (float(np.linalg.norm(waves.mean(axis=0))) for waves in (plain, freed))
    if before <= CONTRADICTED * error or left < MOSTLY * before:
        return False
    scatter, left_scatter = (float(np.sqrt(np.sum(waves.var(axis=0)))) for waves in (plain, freed))
    return left * scatter > before * left_scatter

"""Disturbance: the effort that a place asks for, beside what control and inertia make of the error of the position.

A control answers an error of the position with effort, and an acceleration takes some. So much of an effort's scatter
may go with the errors of the neighbouring samples and tell nothing of the place. How it goes with them is fitted to the
scatter beside the wave, and what they explain is taken away, of the wave too: a disturbance observer whose model is the
stroke itself.

Where the effort is nothing but a control's answer, the torque of a place reaches it through the error alone, and would
be taken away with it. The healthy wave takes the same way as that of a damage at the same wavelength, so what of it
is left tells whether waves may be freed of errors at all.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..criteria import CONTRADICTED, FEWEST_ROWS, MOSTLY, NEGLIGIBLE
from .motion_record import MotionRecord
from .wave import beside_wave

_TAPS = 2  # errors before and after
_TAPS_A_WAVE = 4  # so that those of a quarter wave before and after tell any phase, those of half a wave any trend


def disturbance(
    record: MotionRecord, effort: np.ndarray, rows: np.ndarray, place: np.ndarray, wavelength: float
) -> tuple[np.ndarray, np.ndarray]:
    """(effort (m,) less what the error of the position explains, place (m,)) of the rows (n,) that have neighbours.

    The effort and the place are those of the whole record. Without a command there is no error of the position, and
    too few rows do not tell what it explains: then the effort stays as it is.
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
    # Means over a step leave the scatter about the wave's own frequency, at which the errors are to explain it.
    mean = np.full(step, 1.0 / step)
    slow = np.convolve(error, mean, "same")
    values, where = effort[inside], place[inside]
    errors = np.column_stack([slow[inside + shift] for shift in shifts])
    scatter = beside_wave(errors, where, wavelength)
    squares = scatter.T @ scatter
    # Where errors hardly scatter but in the wave itself, they do not tell what of the effort is theirs.
    floor = NEGLIGIBLE**2 * np.trace(beside_wave(errors, where, np.inf).T @ errors) / len(shifts)
    if not floor > 0.0:
        return values, where
    asked = beside_wave(np.convolve(effort, mean, "same")[inside], where, wavelength)
    shares = np.linalg.solve(squares + floor * np.eye(len(shifts)), scatter.T @ asked)
    return values - np.column_stack([error[inside + shift] for shift in shifts]) @ shares, where


def tells_more(plain: np.ndarray, freed: np.ndarray, tests: Sequence[str]) -> bool:
    """Whether waves freed of errors (n, k) tell a damage of a place better than the plain ones (n, k) of healthy runs.

    They do where the healthy wave is known, the greater share of it is left, and that stands out more over how it
    differs from run to run. The k numbers are those of phasors, the same in both.
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

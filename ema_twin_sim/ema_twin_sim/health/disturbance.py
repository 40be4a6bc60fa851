"""Disturbance: the effort that a place asks for, beside what control and inertia make of the error of the position.

A control answers an error of the position with effort, and an acceleration takes some. So most of an effort's scatter
goes with the errors of the neighbouring samples and tells nothing of the place. How it goes with them is fitted to the
scatter beside the wave, and what they explain is taken away, of the wave too: a disturbance observer whose model is the
stroke itself.
"""

from __future__ import annotations

import numpy as np

from ..criteria import FEWEST_ROWS, NEGLIGIBLE
from .motion_record import MotionRecord
from .wave import beside_wave

_NEIGHBOURS = 2
"""Samples before and after: those of an acceleration, and a sample of delay. Waves of healthy runs of the Cranfield
ball screw scatter least with them: by 0.49 % of the effort from run to run, 0.70 % without any and 0.52 % with six."""


def disturbance(
    record: MotionRecord, effort: np.ndarray, rows: np.ndarray, place: np.ndarray, wavelength: float
) -> tuple[np.ndarray, np.ndarray]:
    """(effort (m,) less what the error of the position explains, place (m,)) of the rows (n,) that have neighbours.

    The effort and the place are those of the whole record. Without a command there is no error of the position, and
    too few rows do not tell what it explains: then the effort stays as it is.
    """
    if record.command is None:
        return effort[rows], place[rows]
    shifts = range(-_NEIGHBOURS, _NEIGHBOURS + 1)
    inside = rows[(rows >= _NEIGHBOURS) & (rows < len(effort) - _NEIGHBOURS)]
    if len(inside) < FEWEST_ROWS + len(shifts):
        return effort[rows], place[rows]
    error = record.command - record.position
    errors = np.column_stack([error[inside + shift] for shift in shifts])
    values, where = effort[inside], place[inside]
    scatter = beside_wave(errors, where, wavelength)
    squares = scatter.T @ scatter
    # Where errors hardly scatter but in the wave itself, they do not tell what of the effort is theirs.
    floor = NEGLIGIBLE**2 * np.trace(beside_wave(errors, where, np.inf).T @ errors) / len(shifts)
    if not floor > 0.0:
        return values, where
    shares = np.linalg.solve(squares + floor * np.eye(len(shifts)), scatter.T @ beside_wave(values, where, wavelength))
    return values - errors @ shares, where

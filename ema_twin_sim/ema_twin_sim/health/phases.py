"""Which samples of a run move steadily each way, start, settle or rest: by the command, else by the measured motion."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from .motion_record import MotionRecord

_SMOOTHED = 5  # samples over which a measured position is averaged before it is differentiated
_FEWEST = 8  # minimum number of steady samples of a piece
_TOP = 95.0  # percentile of the speed's magnitude that counts as the top speed
_STARTING = 4  # a stroke's first quarter is its start
_RESTING = 20  # slower than a twentieth of the top speed is rest


@dataclass(frozen=True, eq=False)
class Piece:
    """Neighbouring samples of one kind of motion."""

    direction: int  # 1, -1, or 0 at rest
    beginning: slice  # the start of a stroke, or settling at rest
    steady: slice  # the samples after it


@dataclass(frozen=True, eq=False)
class Phases:
    """The pieces of a run, and its speed and travel."""

    pieces: tuple[Piece, ...]
    speed: np.ndarray  # m/s or rad/s (n,), of the command if there is one
    top_speed: float  # m/s or rad/s
    travel: float  # m or rad

    def strokes(self, direction: int) -> tuple[Piece, ...]:
        """The pieces that move one way; 0: those at rest."""
        return tuple(piece for piece in self.pieces if piece.direction == direction)


def phases_of(record: MotionRecord) -> Phases:
    """Divide a run into pieces. A stroke is motion one way at more than half the top speed."""
    reference = record.position if record.command is None else record.command
    smooth = _smoothed(reference) if record.command is None else reference
    speed = np.gradient(smooth, record.time)
    top = float(np.percentile(np.abs(speed), _TOP))
    if not top > 0.0:
        return Phases((), speed, 0.0, 0.0)
    kind = np.where(speed > 0.5 * top, 1, np.where(speed < -0.5 * top, -1, 0))
    rests = np.abs(speed) < top / _RESTING
    pieces = []
    edges = [0, *(np.flatnonzero(np.diff(kind) != 0) + 1), len(kind)]
    for first, last in itertools.pairwise(edges):
        direction = int(kind[first])
        if not direction:
            still = np.flatnonzero(rests[first:last])
            if len(still) < 2 * _FEWEST:
                continue
            first, last = first + int(still[0]), first + int(still[-1]) + 1
            middle = (first + last) // 2
        else:
            middle = first + (last - first) // _STARTING
        if last - middle >= _FEWEST:
            pieces.append(Piece(direction, slice(first, middle), slice(middle, last)))
    return Phases(tuple(pieces), speed, top, float(np.ptp(reference)))


def _smoothed(values: np.ndarray) -> np.ndarray:
    """A moving average with the same number of samples."""
    ends = np.pad(values, _SMOOTHED // 2, mode="reflect", reflect_type="odd")
    return np.convolve(ends, np.full(_SMOOTHED, 1.0 / _SMOOTHED), "valid")

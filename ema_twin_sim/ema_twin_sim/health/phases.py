"""Which samples of a run move steadily each way, start, settle, and rest: by what was commanded, else by the motion."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from .motion_record import MotionRecord

_SMOOTHED = 5  # samples over which a measured position is averaged before it is differentiated
_FEWEST = 8  # samples of a piece that tell anything
_TOP = 95.0  # percentile of the speed's magnitude that is called its top
_STARTING = 4  # a stroke's first quarter is its start
_RESTING = 20  # what moves slower than a twentieth of the top speed rests


@dataclass(frozen=True, eq=False)
class Piece:
    """Neighbouring samples of one kind of motion."""

    direction: int  # 1, -1, or 0 at rest
    beginning: slice  # what starts, or settles
    steady: slice  # what follows


@dataclass(frozen=True, eq=False)
class Phases:
    """The pieces of a run, and what they have in common."""

    pieces: tuple[Piece, ...]
    speed: np.ndarray  # m/s or rad/s (n,), of the command where there is one
    top_speed: float  # m/s or rad/s
    travel: float  # m or rad

    def strokes(self, direction: int) -> tuple[Piece, ...]:
        """The pieces that move one way; 0: that rest."""
        return tuple(piece for piece in self.pieces if piece.direction == direction)


def phases_of(record: MotionRecord) -> Phases:
    """The pieces of a run. A stroke is what moves one way faster than half the top speed."""
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
    """A moving average, with as many samples as went in."""
    ends = np.pad(values, _SMOOTHED // 2, mode="reflect", reflect_type="odd")
    return np.convolve(ends, np.full(_SMOOTHED, 1.0 / _SMOOTHED), "valid")

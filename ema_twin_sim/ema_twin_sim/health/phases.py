"""Which samples of a run move steadily each way, start, settle or rest: by the command, else by the measured motion."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from ..criteria import PART, SMALL
from .motion_record import MotionRecord, sensor_step

_SMOOTHED = 5  # samples over which a measured position is averaged before it is differentiated
_FEWEST = 8  # minimum number of steady samples of a piece
_TOP = 95.0  # percentile of the speed's magnitude that counts as the top speed
_STARTING = 4  # a stroke's first quarter is its start
_RESTING = 20  # slower than a twentieth of the top speed may be rest


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
    """Divide a run into strokes and rests.

    A stroke is motion one way, without a rest, from when it first exceeds half of its own top speed to when it last
    does. So a slow move is a stroke as well, and a speed that hovers about some limit makes no stroke two.
    """
    measured = record.command is None
    reference = record.position if record.command is None else record.command
    speed = np.gradient(_smoothed(reference) if measured else reference, record.time)
    top = float(np.percentile(np.abs(speed), _TOP))
    if not top > 0.0:
        return Phases((), speed, 0.0, 0.0)
    still = top / _RESTING
    if measured:  # a reading that ticks to and fro at rest is no motion
        still = max(still, min(PART * top, _speed_of_a_step(record)))
    kind = np.where(np.abs(speed) > still, np.sign(speed), 0.0).astype(int)
    moves, rests = _moves_and_rests(kind, reference)
    pieces = [*(_stroke(kind[move.start], speed, move) for move in moves), *map(_rest, rests)]
    pieces = [piece for piece in pieces if piece.steady.stop - piece.steady.start >= _FEWEST]
    pieces.sort(key=lambda piece: piece.beginning.start)
    return Phases(tuple(pieces), speed, top, float(np.ptp(reference)))


def _moves_and_rests(kind: np.ndarray, reference: np.ndarray) -> tuple[list[slice], list[slice]]:
    """The runs of one direction and those at rest, of the direction of each sample (n,), which this cleans.

    A move goes a considerable part of the farthest one (SMALL), and a rest lasts as long a part of the typical move:
    the speed also passes through zero where the motion reverses.
    """

    def way(run: slice) -> float:
        return float(np.ptp(reference[run])) if kind[run.start] else 0.0

    least = SMALL * max(map(way, _runs(kind)))
    for run in _runs(kind):
        if run.stop - run.start < _FEWEST and way(run) < least:
            kind[run] = 0  # a tick of the encoder
    far = [run for run in _runs(kind) if way(run) >= least]
    shortest = SMALL * float(np.median([run.stop - run.start for run in far]))
    for run in _runs(kind)[1:-1]:
        if run.stop - run.start < shortest and kind[run.start - 1] == kind[run.stop]:
            kind[run] = kind[run.stop]  # it slows down, but goes on
    runs = _runs(kind)
    moves = [run for run in runs if way(run) >= least]
    return moves, [run for run in runs if not kind[run.start] and run.stop - run.start >= shortest]


def _runs(kind: np.ndarray) -> list[slice]:
    """The longest stretches of equal values (n,)."""
    edges = [0, *(np.flatnonzero(np.diff(kind)) + 1), len(kind)]
    return [slice(int(first), int(last)) for first, last in itertools.pairwise(edges)]


def _stroke(direction: int, speed: np.ndarray, move: slice) -> Piece:
    """The piece of a move that is faster than half of its own top speed."""
    along = direction * speed[move]
    fast = move.start + np.flatnonzero(along > 0.5 * np.percentile(along, _TOP))
    first, last = int(fast[0]), int(fast[-1]) + 1
    middle = first + (last - first) // _STARTING
    return Piece(int(direction), slice(first, middle), slice(middle, last))


def _rest(run: slice) -> Piece:
    middle = (run.start + run.stop) // 2
    return Piece(0, slice(run.start, middle), slice(middle, run.stop))


def _speed_of_a_step(record: MotionRecord) -> float:
    """What a measured position that ticks by one step seems to move at; two steps are motion."""
    return 1.5 * sensor_step(record.position) / (_SMOOTHED * float(np.median(np.diff(record.time))))


def _smoothed(values: np.ndarray) -> np.ndarray:
    """A moving average with the same number of samples."""
    ends = np.pad(values, _SMOOTHED // 2, mode="reflect", reflect_type="odd")
    return np.convolve(ends, np.full(_SMOOTHED, 1.0 / _SMOOTHED), "valid")

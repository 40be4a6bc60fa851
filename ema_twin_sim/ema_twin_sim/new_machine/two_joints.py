"""Whether two positions whose names tell no side are two joints' and not the motor's and the output's of one drive.

Between the shafts of a drive the ratio is the same in every recording and all along it. Joints that go almost in step
show one for a while only.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from ema_bench_replay.recording import Recording
from ema_bench_replay.traces.header_words import header_words

from ..criteria import PART, SMALL
from .column_quantity import has_word
from .column_words import MOTOR, MOVED, OUTPUT
from .columns import Guess, Guesses
from .joints import likeness

_PIECES = 4  # of a recording, in each of which the ratio must hold
_BOTH = ("motor_position", "output_position")


def two_joints(recordings: Sequence[Recording], guesses: Guesses) -> str:
    """Why the position of the output is another joint's; empty if it may be the output's, or if its name says so."""
    motor, output = (guesses.by_signal.get(name) for name in _BOTH)
    if motor is None or output is None or _tells_a_side(motor) or _tells_a_side(output):
        return ""
    moved = _moved([recording for recording in recordings if recording.has(*_BOTH) and not recording.of_points])
    ratios = [ratio for recording in moved for ratio in _ratios(recording)]
    if not ratios:
        return ""
    apart = max(_apart(recording) for recording in moved)
    lowest, highest = min(ratios), max(ratios)
    middle = float(np.median(ratios))
    if max(highest - middle, middle - lowest) > SMALL * abs(middle):
        why = f"their ratio is {lowest:.3g} in one part of the recordings and {highest:.3g} in another"
    elif apart > SMALL:
        why = f"{100.0 * apart:.0f} % of the one's way is not the other's"
    else:
        return ""
    return (
        f"not used as the output's position: {motor.column} and {output.column} look like two joints and not like "
        f"motor and output of one drive, since {why} (if they are of one drive, say so in their names, as in 'motor "
        "position' and 'output position'; else remove the other joint's columns; and run init again)"
    )


def _moved(recordings: Sequence[Recording]) -> list[Recording]:
    """The recordings in which a position goes a considerable part of its longest way; at rest both tell noise."""
    ways = np.array([[_way(recording.signals[name]) for name in _BOTH] for recording in recordings]).reshape(-1, 2)
    far = (ways > PART * ways.max(axis=0, initial=0.0)).any(axis=1)
    return [recording for recording, enough in zip(recordings, far, strict=True) if enough]


def _way(position: np.ndarray) -> float:
    known = position[np.isfinite(position)]
    return float(np.ptp(known)) if len(known) else 0.0


def _tells_a_side(guess: Guess) -> bool:
    """Whether a word of a column's name tells the motor or what it moves; a number may be that of a joint."""
    words = [word for word in header_words(guess.column).words if not word.isdigit()]
    return has_word(words, f"{MOTOR}|{OUTPUT}|{MOVED}")


def _ratios(recording: Recording) -> Iterator[float]:
    """Yield the ratio of the motor's way to the output's in each piece in which both go a considerable part of it."""
    ways = [recording.signals[name] for name in _BOTH]
    known = np.isfinite(ways[0]) & np.isfinite(ways[1])
    whole = [way[known] for way in ways]
    for piece in np.array_split(np.arange(len(whole[0])), _PIECES):
        motor, output = (way[piece] for way in whole)
        if len(piece) and all(np.ptp(way[piece]) > PART * np.ptp(way) for way in whole):
            sign = math.copysign(1.0, float((motor - motor.mean()) @ (output - output.mean())))
            yield sign * float(np.std(motor) / np.std(output))


def _apart(recording: Recording) -> float:
    """The share of one way that is not the other's."""
    return math.sqrt(1.0 - likeness(*(recording.signals[name] for name in _BOTH)) ** 2)

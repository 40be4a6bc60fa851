"""Whether a position that no header explains belongs to the speed beside it: whether it goes where the speed goes.

Of several, the one that goes with the speed most is the machine's: others are of another axis, or of the whole robot.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from ema_bench_replay.recording import Recording
from ema_bench_replay.traces.wrapped_angle import counted_on

from ..criteria import LIKELY, MOSTLY, NEGLIGIBLE, PART, SMALL, SPIKE
from ..measured.spoilt_samples import spoilt
from ..measured.way_by_speed import FEWEST, travelled_by_speed, without_pauses
from ..reading_noise import reading_noise

_PARTS = (20, 40, 100)  # of a recording, over each of which the ways are compared
_TRIMMED = 5  # times that the rows that are farthest off are left out anew


def not_summed(recordings: Sequence[Recording]) -> str:
    """Why a motor position is no position if it looks like the counts since the last sample; else empty."""
    strange = _unlike_speed(recordings)
    summed = (_alike(_summed(_position(r)), travelled_by_speed(r), beside_means=True) for r in strange)
    if not strange or any(alike < MOSTLY for alike in summed):
        return ""
    return (
        "not used: it looks like the counts since the last sample, since its sum goes as the speed says and it does "
        "not itself (to use it, write its sum into the column)"
    )


def unlike_speed(recordings: Sequence[Recording]) -> str:
    """Why a motor position is none if it has nothing to do with the speed in any recording; else empty.

    It may do so between jumps, as where a recording is put together of pieces.
    """
    strange = _unlike_speed(recordings)
    if not strange:
        return ""
    jumps = [_jumps(recording) for recording in strange]
    if all(jumps):
        return (
            f"not used: in {sum(jumps)} of {sum(map(len, strange))} rows it jumps farther than the speed goes, though "
            "it goes with that between these (are samples missing there, or are single values wrong?)"
        )
    return "not used: it has nothing in common with the integral of the speed"


def share_beside_speed(recordings: Sequence[Recording]) -> float:
    """The share of a motor position's way (rms) that is not the speed's in any unit, where both go together most.

    Little (0 too if no recording shows both) if they are of one shaft, and much of two that move almost in step.
    """
    judged = [recording for recording in recordings if _shows_motion(recording)]
    alike = max((_likeness(recording) for recording in judged), default=1.0)
    return math.sqrt(max(0.0, 1.0 - alike**2))


def going_with_speed(positions: Mapping[str, np.ndarray], speed: np.ndarray, time: np.ndarray) -> frozenset[str]:
    """The names of the ``positions`` (n,) that go with a ``speed`` (n,) most; all if none does, or with too few rows.

    Several do if they are of one drive train. Units do not matter, nor steps at which a ``time`` (n,) goes back.
    """
    known = np.isfinite(speed) & np.isfinite(time)
    if known.sum() < FEWEST:
        return frozenset(positions)
    time, speed = time[known], speed[known]
    steps = np.diff(time)
    steps = np.where(steps > 0.0, steps, float(np.median(steps)))
    travelled = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * steps)])
    alike = {name: _alike_if_counted_on(values[known], travelled) for name, values in positions.items()}
    most = max(alike.values(), default=0.0)
    if most < PART:
        return frozenset(positions)
    return frozenset(name for name, likeness in alike.items() if likeness >= (1.0 - SMALL) * most)


def _alike_if_counted_on(position: np.ndarray, travelled: np.ndarray) -> float:
    """How far a position (n,), which may start again after each turn, goes with a displacement (n,)."""
    known = position[np.isfinite(position)]
    span = float(np.ptp(known)) if len(known) else 0.0
    on, turns = counted_on(position, span) if span > 0.0 else (position, 0)
    return max(_alike(position, travelled), _alike(on, travelled) if turns else 0.0)


def _unlike_speed(recordings: Sequence[Recording]) -> list[Recording]:
    """The recordings that show a motion, if the motor position goes where the speed goes in none of them."""
    judged = [recording for recording in recordings if _shows_motion(recording)]
    return [] if any(_likeness(recording) >= PART for recording in judged) else judged


def _likeness(recording: Recording) -> float:
    """How far a recording's motor position goes where its speed goes, 0 to 1."""
    position, wrong = _position(recording), spoilt(recording.signals["motor_position"])
    if np.mean(wrong) < NEGLIGIBLE:  # these are left out wherever the recording is used
        position = np.where(wrong, np.nan, position)
    return _alike(*without_pauses(recording, position, travelled_by_speed(recording)))


def _jumps(recording: Recording) -> int:
    """In how many rows a position goes far beyond the speed, if it goes with it in all others; else 0."""
    both = without_pauses(recording, recording.signals["motor_position"], travelled_by_speed(recording))
    steps, ways = map(np.diff, both)
    known = np.isfinite(steps) & np.isfinite(ways)
    steps, ways = steps[known], ways[known]
    kept = np.ones(len(steps), bool)
    left = np.abs(steps)
    for _ in range(_TRIMMED):
        kept = left <= np.quantile(left, 1.0 - SMALL) if len(left) else kept
        square = float(ways[kept] @ ways[kept])
        if not square > 0.0:
            return 0
        left = np.abs(steps - float(ways[kept] @ steps[kept]) / square * ways)
    size = float(np.linalg.norm(steps[kept]) * np.linalg.norm(ways[kept]))
    if kept.sum() < FEWEST or not abs(float(steps[kept] @ ways[kept])) >= PART * size > 0.0:
        return 0
    return int(np.count_nonzero(left > SPIKE * float(np.sqrt(np.mean(left[kept] ** 2)))))


def _shows_motion(recording: Recording) -> bool:
    """Whether a recording has both, and a speed that changes by more than its readings do."""
    if recording.of_points or not recording.has("speed", "motor_position") or len(recording) < FEWEST:
        return False
    speed = recording.signals["speed"][np.isfinite(recording.signals["speed"])]
    return len(speed) >= FEWEST and float(np.std(speed)) > LIKELY * reading_noise(speed)


def _position(recording: Recording) -> np.ndarray:
    """The position (n,) as it was read, from the counter's own zero."""
    origin = recording.motor_angle_origin
    return recording.signals["motor_position"] + (0.0 if math.isnan(origin) else origin)


def _summed(steps: np.ndarray) -> np.ndarray:
    """The sum (n,) up to each sample, NaN where a step is; the missing step itself is left out."""
    missing = np.isnan(steps)
    return np.where(missing, np.nan, np.cumsum(np.where(missing, 0.0, steps)))


def _alike(one: np.ndarray, other: np.ndarray, *, beside_means: bool = False) -> float:
    """How far two motions (n,) go the same ways, 0 to 1, over parts of the length at which they are most alike.

    ``beside_means`` leaves out what both go on average: the sum of a constant goes on and on.
    """
    best = 0.0
    for parts in _PARTS:
        lag = max(1, len(one) // parts)
        ways = one[lag:] - one[:-lag], other[lag:] - other[:-lag]
        known = np.isfinite(ways[0]) & np.isfinite(ways[1])
        if known.sum() < FEWEST:
            continue
        first, second = (way[known] - (way[known].mean() if beside_means else 0.0) for way in ways)
        size = math.sqrt(float(first @ first) * float(second @ second))
        best = max(best, abs(float(first @ second)) / size if size > 0.0 else 0.0)
    return best

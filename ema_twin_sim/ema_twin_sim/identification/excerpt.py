"""Excerpts: the few seconds of each recording most informative about backlash and compliance, for repeated trials."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ..criteria import PART, STANDSTILL
from ..measured.observation import Observation
from ..plant.motion import SPEED
from .equation import EquationErrorProblem

EXCERPT = 4.0  # own s
EXCERPTS = 4
MOST_TURNS = 8  # reversals of an excerpt beyond which more add nothing


def excerpt(problem: EquationErrorProblem) -> EquationErrorProblem:
    """The seconds of each recording with the most reversals, for a few recordings.

    Longer excerpts are used if no recording reverses within the usual time. If none reverses at all, as on a conveyor,
    they are whole: the teeth may change flanks wherever the drive brakes.
    """
    seen = [o for o in problem.observations if len(o.encoder_rows)]
    longest = max((o.period * len(o.motion) for o in seen), default=EXCERPT)
    doublings = max(0, math.ceil(math.log2(longest / EXCERPT)))
    found: list[tuple[float, Observation]] = []
    for k in range(doublings + 1):
        found = [_telling(o, EXCERPT * 2.0**k, problem.size > 0) for o in seen]
        if any(count > 0.0 for count, _ in found):
            break
    found.sort(key=lambda entry: -entry[0])
    part = EquationErrorProblem([o for _, o in found[:EXCERPTS]])
    return part.under(replace(part.weighting, variance_inflation=problem.weighting.variance_inflation))


def _telling(o: Observation, duration: float, by_torque: bool) -> tuple[float, Observation]:
    """(reversals times share in motion, excerpt) of the best stretch of ``duration`` [own s]."""
    length = min(len(o.motion) - 1, round(duration / o.period))
    if by_torque:  # play is crossed some time after a reversal
        first, count = _most_reversals(o, length, round(PART * length))
        return count, o.window(first, first + length)
    first, count = _most_reversals(o, length)
    # without torque data, own seconds follow only from a typical speed: several reversals make a stretch long enough
    while count < MOST_TURNS // 2 and length < len(o.motion) - 1:
        length = min(len(o.motion) - 1, 2 * length)
        first, count = _most_reversals(o, length)
    return count, o.window(first, first + length)


def _most_reversals(o: Observation, length: int, edge: int = 0) -> tuple[int, float]:
    """(first sample, reversals times share in motion) of the best stretch of this many samples.

    A reversal counts if encoder rows are judged before and after it: not while the output is in flight; and if it is
    at least ``edge`` samples from either end.
    """
    speed = o.motion[:, SPEED]
    turn = np.flatnonzero(np.diff(np.sign(speed[o.encoder_rows])) != 0)
    until = np.searchsorted(o.encoder_rows[turn + 1], np.arange(length, len(speed) + 1) - edge)
    before = np.searchsorted(o.encoder_rows[turn], np.arange(len(speed) - length + 1) + edge)
    moving = np.concatenate([[0.0], np.cumsum(np.abs(speed) > STANDSTILL)])
    share = (moving[length:] - moving[: len(moving) - length]) / length
    count = np.clip(until - before, 0, MOST_TURNS) * share  # chatter at standstill is no reversal
    first = int(np.argmax(count))
    return first, float(count[first])

"""Excerpts: the few seconds of each recording that tell most about play and spring, for what must be tried often."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..criteria import STANDSTILL
from ..measured.observation import Observation
from ..plant.measured_motion import SPEED
from .equation import EquationErrorProblem

EXCERPT = 4.0  # own s
EXCERPTS = 4
MOST_TURNS = 8  # reversals of an excerpt from which on more tell no more


def excerpt(problem: EquationErrorProblem) -> EquationErrorProblem:
    """The seconds of each recording that hold the most reversals, of a few recordings."""
    found = []
    for o in problem.observations:
        if len(o.encoder_rows):
            length = min(len(o.motion) - 1, round(EXCERPT / o.period))
            first, count = _most_reversals(o, length)
            # own seconds of a machine whose torque nobody measured are no more than a typical speed's
            while not problem.size and count < MOST_TURNS // 2 and length < len(o.motion) - 1:
                length = min(len(o.motion) - 1, 2 * length)
                first, count = _most_reversals(o, length)
            found.append((count, o.window(first, first + length)))
    found.sort(key=lambda entry: -entry[0])
    part = EquationErrorProblem([o for _, o in found[:EXCERPTS]])
    return part.under(replace(part.weighting, variance_inflation=problem.weighting.variance_inflation))


def _most_reversals(o: Observation, length: int) -> tuple[int, float]:
    """(first sample, reversals times share in motion) of the best stretch of so many samples."""
    speed = o.motion[:, SPEED]
    turns = np.concatenate([[0.0], np.cumsum(np.diff(np.sign(speed)) != 0)])
    moving = np.concatenate([[0.0], np.cumsum(np.abs(speed) > STANDSTILL)])
    count = turns[length - 1 :] - turns[: len(turns) - length + 1]
    share = (moving[length:] - moving[: len(moving) - length]) / length
    count = np.minimum(count, MOST_TURNS)[: len(share)] * share  # chatter at standstill is no reversal
    first = int(np.argmax(count))
    return first, float(count[first])

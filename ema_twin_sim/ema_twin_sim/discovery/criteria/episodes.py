"""Episodes: stretches of time in which a machine behaved differently than before and after."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...criteria import FAR_OUT
from ...identification.equation import EquationErrorProblem
from ...identification.fit import Fit
from ...plant.motion import SPEED, TIME

SHORTEST = 0.1  # own s
HOLES = 0.2  # own s within an episode in which rows may be close again, or not judged


@dataclass(frozen=True)
class Episode:
    """One stretch of a recording, and the mean torque [N m, fast shaft] that it needs beyond the model.

    ``against`` is positive if that torque brakes the motion.
    """

    recording: str
    start: float  # s
    end: float  # s
    torque: float
    against: float


def episodes(problem: EquationErrorProblem, f: Fit) -> tuple[Episode, ...]:
    """Stretches in which the residual is far above the noise; empty if it is so throughout."""
    found = []
    far_rows = in_episodes = 0
    for o, part in zip(problem.observations, problem.torque_parts, strict=True):
        if o.of_points:  # operating points have no time order
            continue
        raw = f.raw[part]
        time = o.motion[o.rows, TIME]
        far = np.flatnonzero(np.abs(raw) > FAR_OUT)
        far_rows += len(far)
        if not len(far) or len(far) > 0.5 * len(raw):
            continue
        for piece in np.split(far, np.flatnonzero(np.diff(time[far]) > HOLES) + 1):
            start, end = float(time[piece[0]]), float(time[piece[-1]])
            if end - start < SHORTEST:
                continue
            in_episodes += len(piece)
            torque = raw[piece] * o.torque_noise[piece]
            braking = torque * np.sign(o.motion[o.rows[piece], SPEED])
            found.append(Episode(o.name, start, end, float(np.mean(torque)), float(np.mean(braking))))
    return tuple(found) if in_episodes > 0.5 * far_rows else ()


def listed_episodes(found: Sequence[Episode], most: int = 6, second: float = 1.0) -> str:
    """``RUN from 4.91 s to 6.72 s, …``: the longest ones in order of time; ``second`` is their unit of time in s."""
    longest = sorted(found, key=lambda e: e.start - e.end)[:most]
    told = [f"{e.recording} from {second * e.start:.2f} s to {second * e.end:.2f} s" for e in found if e in longest]
    more = len(found) - len(told)
    return ", ".join(told) + (f", and {more} more" if more else "")

"""What to record next, in one line."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ema_bench_replay.recording import Recording

from ...criteria import STANDSTILL
from ...identification.equation import EquationErrorProblem
from ...listing import listed
from ...measured.observation import Observation
from ...plant.motion import SPEED
from ..search.rivals import Rivalry
from ..search.trace import Search
from .doubts import NOTHING, doubts
from .next_command import best_command

SLOW, FAST = 1000, 250
"""Samples from one reversal to the next. Without torque data, the sample rate is the only measure of how quick a
machine is: its own second follows from how fast it was moved. A slow triangle and two quick sines of
``tests/discovery/test_two_encoders.py`` take 4.6 and 5.3 own s, but 2700 and 400 samples."""


def suggest(
    problem: EquationErrorProblem,
    found: Search,
    rivals: Sequence[Rivalry],
    recordings: Sequence[Recording],
    without: frozenset[str] = frozenset(),
) -> str:
    """What to record next, in a line that begins with the command; empty if nothing is in doubt."""
    if not problem.size:
        return _of_encoders(problem, rivals)
    held = doubts(problem, found, rivals, without, thorough=False)
    if not held:
        return ""
    if any(recording.of_points for recording in recordings):
        return "a motion, slow and fast, in both directions: operating points show no more"
    choice = best_command(problem, found.fit, held, recordings, few=True)
    if choice.best is None:
        names = [name for name in dict.fromkeys(n for d in held for n in d.names) if name != NOTHING]
        said = f"tells {listed(names)} apart" if len(names) > 1 else f"shows whether {names[0]} is there too"
        return f"none of the commands that were tried {said}; plan tries more".replace("_", " ")
    further = f"; beyond what was recorded, see that the bench allows it: {', '.join(choice.best.beyond)}"
    beyond = further if choice.best.beyond else ""
    return f"{choice.best.command} for {choice.best.seconds:g} s: {choice.best.why}{beyond}"


def _of_encoders(problem: EquationErrorProblem, rivals: Sequence[Rivalry]) -> str:
    """Next recording for two encoders without torque data: the missing kind of motion, else the torque."""
    between = [_between_reversals(o) for o in problem.observations]
    if any(len(rivalry.group) > 1 for rivalry in rivals) or min(between) > SLOW:
        return "reversals as fast as the machine allows: in slow motion a shaft wound up by friction looks like play"
    if max(between) < FAST:
        return "a slow triangle at one low speed: there play shows alone, without vibration or delay"
    return "the same motion with the drive's torque or current recorded: it shows loads and friction"


def _between_reversals(o: Observation) -> float:
    """Average number of samples from one reversal to the next; infinite without reversals."""
    speed = o.motion[:, SPEED]
    count = int(np.count_nonzero(np.diff(np.sign(speed[np.abs(speed) > STANDSTILL]))))
    return len(speed) / count if count else math.inf

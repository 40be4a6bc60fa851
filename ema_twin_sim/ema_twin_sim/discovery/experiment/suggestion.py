"""What to record next, in a line."""

from __future__ import annotations

from collections.abc import Sequence

from ema_bench_replay.recording import Recording

from ...identification.equation import EquationErrorProblem
from ..search.rivals import Rivalry
from ..search.trace import Search
from .doubts import NOTHING, doubts
from .next_command import best_command, signals_of


def suggest(
    problem: EquationErrorProblem,
    found: Search,
    rivals: Sequence[Rivalry],
    recordings: Sequence[Recording],
    without: frozenset[str] = frozenset(),
) -> str:
    """What to record next, in a line that begins with the command; empty where nothing is in doubt."""
    if not problem.size:
        return "the same motion with the drive's torque or current: it tells of loads and friction"
    held = doubts(problem, found, rivals, without, thorough=False)
    if not held:
        return ""
    if any(recording.of_points for recording in recordings):
        return "a motion, slow and fast and both ways: operating points tell of no more"
    choice = best_command(problem, held, signals_of(recordings), few=True)
    if choice.best is None:
        names = [name for name in dict.fromkeys(n for d in held for n in d.names) if name != NOTHING]
        said = f"tells apart {' and '.join(names)}" if len(names) > 1 else f"tells whether there is {names[0]} too"
        return f"no command within what was recorded {said}".replace("_", " ")
    further = f"; beyond what was recorded, see that the bench allows it: {', '.join(choice.best.beyond)}"
    beyond = further if choice.best.beyond else ""
    return f"{choice.best.command} for {choice.best.seconds:g} s: {choice.best.why}{beyond}"

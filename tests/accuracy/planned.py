"""Planned recordings: one slow one, and at most two that ``plan`` asks for, against as many that nobody planned."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ema_bench_replay.recording import Recording
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.discovery.plan import plan
from ema_twin_sim.simulation.command import parse_command

from .cases import Case, drawn_cases
from .commands import Drive
from .judge import Verdict, broken, judge

SLOW = Drive("triangle", 0.015, 2.0)
AT_MOST = 2  # recordings after the slow one


@dataclass(frozen=True)
class Asked:
    """What a plan asks for, as the bench drives it: a command of speed by the way that it leads."""

    command: str

    @property
    def name(self) -> str:
        """As a file's name."""
        return self.command.replace(":", "_")

    def __call__(self, time: np.ndarray) -> np.ndarray:
        """Angles [rad] (n,) at times [s] (n,), from zero on."""
        asked = parse_command(self.command)
        values = asked(time)
        if not asked.speed:
            return values
        return np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(time))])


@dataclass(frozen=True)
class Pair:
    """A case by its planned recordings, and by others."""

    case: str
    commands: tuple[str, ...]
    planned: Verdict
    unplanned: Verdict

    def line(self) -> str:
        """One line for the screen."""
        asked = ", ".join(self.commands) or "nothing"
        said = " ".join(
            f"{how} {'ok  ' if v.found else 'MISS'} {','.join(v.added) or '-'} ({v.verdict}){' ' + v.error}"
            for how, v in (("planned", self.planned), ("unplanned", self.unplanned))
        )
        return f"{self.case:16s} hidden={','.join(self.planned.hidden) or '-'} asked for {asked}: {said}"


def planned_cases(seed: int, count: int) -> list[Case]:
    """Cases with one hidden effect, or none or two, of which the slow recording is the first."""
    cases = drawn_cases(seed, count, ("plain", "pairs", "none"))
    return [replace(case, train_drives=(SLOW, *case.train_drives)) for case in cases]


def planned_and_not(case: Case, without: Sequence[str] = ()) -> Pair:
    """What discovery makes of a case with planned recordings, and with the next that were drawn."""
    asked: list[tuple[str, float]] = []
    slow = replace(case, train_drives=(SLOW,)).train
    recordings = slow
    for _ in range(AT_MOST):
        proposal = plan(recordings, case.start_model, without=tuple(without)).proposal
        if proposal is None:
            break
        asked.append((proposal.command, proposal.seconds))
        recordings = _recorded(case, asked)
    return Pair(
        case.name,
        tuple(command for command, _ in asked),
        _judged(case, recordings, without),
        _judged(case, case.train[: 1 + max(len(asked), 1)], without),
    )


def _recorded(case: Case, asked: Sequence[tuple[str, float]]) -> tuple[Recording, ...]:
    """The slow recording and those asked for, each for as long as it was asked for."""
    slow, *others = replace(case, train_drives=(SLOW, *(Asked(command) for command, _ in asked))).train
    return slow, *(other.between(0.0, seconds) for other, (_, seconds) in zip(others, asked, strict=True))


def _judged(case: Case, recordings: Sequence[Recording], without: Sequence[str]) -> Verdict:
    start = time.perf_counter()
    try:
        answer = discover(recordings, case.start_model, without=tuple(without)).as_json()
    except Exception as error:  # whatever it is, the case is lost and the others go on
        return broken(case, error, time.perf_counter() - start)
    return judge(case, answer, time.perf_counter() - start)

"""The next command: of many that are simulated under all rivals, the one that separates these best.

Among commands that decide as much between rivals, the best is the one that would show most effects of the catalogue
which the recordings so far cannot show (``detection``).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from ema_bench_replay.recording import Recording

from ...criteria import DECIDED, LARGEST_EFFECT, MOSTLY, NEARLY_ALL, SEARCHED_UP_TO, SIGNIFICANT
from ...identification.equation import EquationErrorProblem
from ...identification.fit import Fit
from .bench_limits import Limits, driven_limits, widened
from .detection import Detection, Showing, share_told
from .doubts import Doubt
from .rival_field import STEPS, Evaluated, Pair, RivalField

_TURNS = 8  # preferred number of half periods in a recording
_FINALISTS = 8  # commands that are evaluated again, without linearising
_FEW_FINALISTS = 2
_RUNNERS_UP = 3
_SIDE_BY_SIDE = ThreadPoolExecutor(2)  # separate from that of side_by_side, which works within each command


@dataclass(frozen=True)
class Proposal:
    """A command to record next, and what it would show."""

    command: str  # as ``simulate --command`` takes it
    seconds: float
    separation: Mapping[Pair, float]  # standard deviations by which it separates each pair of rivals
    beyond: tuple[str, ...]  # limits of the recordings so far that it would exceed
    why: str
    shows: Mapping[str, tuple[float, float]]  # standard errors of hidden effects: so far, and with it
    hides: tuple[str, ...] = ()  # effects hidden even with it, though another recording would show them

    def as_json(self) -> dict[str, object]:
        """SI units."""
        return {
            "command": self.command,
            "seconds": self.seconds,
            "separation": [
                {"between": list(pair), "standard_deviations": value} for pair, value in self.separation.items()
            ],
            "beyond": list(self.beyond),
            "why": self.why,
            "shows": [{"effect": id, "standard_errors": then, "so_far": now} for id, (now, then) in self.shows.items()],
            "hides": list(self.hides),
        }


@dataclass(frozen=True)
class Choice:
    """The best command, if any decides or shows something, the runners-up, and the pairs that none separates."""

    best: Proposal | None
    runners_up: tuple[Proposal, ...]
    inseparable: tuple[Pair, ...]
    so_far: Showing | None = None  # what the recordings so far show of other effects; None if not needed


def best_command(
    problem: EquationErrorProblem,
    found: Fit,
    held: Sequence[Doubt],
    recordings: Sequence[Recording],
    *,
    detection: Detection | None = None,
    limits: Limits | None = None,
    few: bool = False,
    progress: Callable[[str], None] = lambda text: None,
) -> Choice:
    """The command that decides most doubts about ``found``, with the largest minimum separation.

    With ``detection``, among those the one that shows most of what the recordings so far do not show; ``held`` may then
    be empty. ``recordings`` are the matched ones, whose signals the bench records; ``limits`` are in own units. Without
    limits, the command stays within what the recordings have driven, unless only a command beyond that decides more
    doubts or shows more effects. ``few`` tries only a handful.
    """
    in_all = frozenset.intersection(*(frozenset(recording.signals) for recording in recordings))
    field = RivalField(problem, found, held, in_all, detection)
    allowed = limits or driven_limits(problem.observations, field.base.value("machine.gear_ratio"))
    tried = _evaluate_all(field, allowed, few, (), progress)
    if limits is None and (detection is not None or not any(_decides_all(e) for e in tried)):
        # Whether more would show beyond the limits is found by trying. An effect that slow motion does not show at all
        # may need much more speed than a doubt between rivals.
        faster = LARGEST_EFFECT if detection is None else SEARCHED_UP_TO
        more = widened(allowed, field.base, field.origins[1], faster)
        tried += _evaluate_all(field, more, few, tried, progress)
    tried, so_far = _told_apart(field, tried)
    finalists = _varied(_ranked(tried, allowed, so_far))[: _FEW_FINALISTS if few else _FINALISTS]
    if field.pairs:
        progress("looking closer at the best commands")
        finalists = list(
            _SIDE_BY_SIDE.map(lambda e: replace(e, separation=field.separation(e.trial, STEPS)), finalists)
        )
    ranked = _ranked(finalists, allowed, so_far)
    separable = {pair for e in (*tried, *finalists) for pair, value in e.separation.items() if value >= DECIDED}
    inseparable = tuple(pair for pair in field.pairs if pair not in separable)
    telling = [e for e in _varied(ranked) if _tells(e, so_far)]
    if not ranked or ranked[0] not in telling:
        there = None if field.reversed or not field.pairs else _there_and_back(field, allowed, few)
        return Choice(there, (), tuple(field.pairs), so_far)
    chosen = [ranked[0], *(e for e in telling if e is not ranked[0])]
    proposals = []
    for k, e in enumerate(chosen[: 1 + _RUNNERS_UP]):
        shows = _shows(e, so_far)
        driven, then = (of.shown(field.base, recordings) for of in (allowed, e.done))
        beyond = driven.exceeded(then) if limits is None else ()
        why = field.why(e, shows) if k == 0 else ""
        hides = () if e.showing is None else e.showing.hidden()
        proposals.append(Proposal(e.trial.asked, e.trial.lasts, e.separation, beyond, why, shows, hides))
    return Choice(proposals[0], tuple(proposals[1:]), inseparable, so_far)


def _decides_all(e: Evaluated) -> bool:
    """Whether a command decides all doubts."""
    return all(value >= DECIDED for value in e.separation.values())


def _told_apart(field: RivalField, tried: Sequence[Evaluated]) -> tuple[list[Evaluated], Showing | None]:
    """The same commands with what each would show, and what the recordings so far show."""
    detection = field.detection
    if detection is None or not detection.effects or not tried:
        return list(tried), None
    apart = [detection.apart(detection.so_far + e.information) for e in tried if e.information is not None]
    matters = np.max(apart, axis=0) >= DECIDED
    told = [replace(e, showing=Showing(detection.effects, a, matters)) for e, a in zip(tried, apart, strict=True)]
    return told, Showing(detection.effects, detection.apart(detection.so_far), matters)


def _shows(e: Evaluated, so_far: Showing | None) -> dict[str, tuple[float, float]]:
    """Effects that stand out with a command but not so far, clearest first, with both values."""
    if so_far is None or e.showing is None:
        return {}
    found = {
        id: (float(now), float(then))
        for id, now, then in zip(so_far.effects, so_far.standing_out, e.showing.standing_out, strict=True)
        if now < SIGNIFICANT and then >= DECIDED
    }
    return dict(sorted(found.items(), key=lambda entry: -entry[1][1]))


def _tells(e: Evaluated, so_far: Showing | None) -> bool:
    """Whether a command decides between rivals, or shows a hidden effect."""
    return max(e.separation.values(), default=0.0) >= DECIDED or bool(_shows(e, so_far))


def _there_and_back(field: RivalField, limits: Limits, few: bool) -> Proposal | None:
    """A triangle with at most half the allowed speed and travel; its outcome cannot be predicted."""
    half = replace(limits, speed=0.5 * limits.speed, lower=0.5 * limits.lower, upper=0.5 * limits.upper)
    triangles = [trial for trial in field.grid(half, few=few) if trial.kind == "triangle"]
    if not triangles:
        return None
    trial = min(triangles, key=lambda trial: abs(trial.turns - _TURNS))
    return Proposal(trial.asked, trial.lasts, {}, (), "no recording reverses yet; the outcome cannot be predicted", {})


def _evaluate_all(
    field: RivalField, limits: Limits, few: bool, before: Sequence[Evaluated], progress: Callable[[str], None]
) -> list[Evaluated]:
    """All commands of the grid that stay within limits and were not evaluated before."""
    known = {e.trial for e in before}
    trials = [trial for trial in field.grid(limits, few=few) if trial not in known]
    rivals = "" if len(field.contenders) < 2 else f" under {len(field.contenders)} rivals"
    progress(f"simulating {len(trials)} commands{rivals}")
    return [e for e in _SIDE_BY_SIDE.map(lambda trial: field.evaluate(trial, limits), trials) if e is not None]


def _ranked(found: Sequence[Evaluated], allowed: Limits, so_far: Showing | None) -> list[Evaluated]:
    """Best first, by these criteria in turn.

    * Most pairs decided.
    * Within limits; if a command beyond them decides or shows more than all within, those that do.
    * How clearly all effects show and all pairs separate, each counted alike: a pair that is barely decided may be left
      open on the bench. If effects are not requested, the largest minimum separation.
    * Among nearly equal ones, the gentlest.
    """
    separable = {pair for e in found for pair, value in e.separation.items() if value >= DECIDED}
    clear = {e: e.showing.named + _pairs_told(e) for e in found if e.showing is not None}
    least = min(clear.values(), default=0.0)

    gains = {e: (sum(value >= DECIDED for value in e.separation.values()), len(_shows(e, so_far))) for e in found}
    within = max((gains[e] for e in found if allowed.effort(e.done) <= 1.0), default=(0, 0))
    enough = all(gained <= within for gained in gains.values())

    def rank(e: Evaluated) -> tuple[int, bool, float]:
        liked = allowed.effort(e.done) <= 1.0 if enough else gains[e] > within
        if e.showing is not None:
            return gains[e][0], liked, clear[e] - least
        smallest = min((value for pair, value in e.separation.items() if pair in separable), default=0.0)
        return gains[e][0], liked, min(smallest, DECIDED**2)

    ranks = {e: rank(e) for e in found}
    left = sorted(found, key=ranks.__getitem__, reverse=True)
    ordered: list[Evaluated] = []
    while left:
        most, liked, best = ranks[left[0]]
        share = MOSTLY if left[0].showing is None else NEARLY_ALL
        alike = [e for e in left if ranks[e][:2] == (most, liked) and ranks[e][2] >= share * best]
        # at most half the driven limits counts as gentle, and several reversals average out drift
        gentlest = min(
            alike,
            key=lambda e: (
                e.trial.kind.startswith("speed-"),
                max(0.5, round(allowed.effort(e.done), 1)),
                abs(e.trial.turns - _TURNS),
            ),
        )
        ordered.append(gentlest)
        left.remove(gentlest)
    return ordered


def _pairs_told(e: Evaluated) -> float:
    """Expected number of pairs that a command tells apart, each as a share: one half if it separates by DECIDED."""
    return sum(share_told(value) for value in e.separation.values())


def _varied(ranked: Sequence[Evaluated]) -> list[Evaluated]:
    """The same, with the best of each kind of command first."""
    first = {e.trial.kind: e for e in reversed(ranked)}
    return sorted(ranked, key=lambda e: first[e.trial.kind] is not e)

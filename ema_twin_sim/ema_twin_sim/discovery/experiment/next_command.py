"""The command that would best tell rivals apart: each is simulated under many, and the others try to explain it.

A rival may move every free number of its own, as far as the recordings so far and its tolerance leave it free. What it
still cannot explain of another's simulated recording, and what it has to give up for the rest, is how far the two would
come apart: in standard deviations, of the noise and of what no rival explains.

Of commands that decide as much between rivals, the best is the one after which most effects of the catalogue would show
that the recordings so far cannot have shown (``detection``).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording

from ...criteria import (
    CLEARLY_MORE,
    DECIDED,
    LARGEST_EFFECT,
    MOSTLY,
    NEARLY_ALL,
    RIVAL_MARGIN,
    SEARCHED_UP_TO,
    SIGNIFICANT,
    STANDSTILL,
)
from ...identification.equation import EquationErrorProblem
from ...identification.fit import Fit
from ...identification.hypothesis import Hypothesis
from ...identification.jacobian import jacobian
from ...measured.observation import Observation, observe
from ...model.own_units import shown
from ...plant.measured_motion import SPEED, TIME
from ...simulation.command import parse_command
from ...simulation.lumped_model import lumped_model
from ...simulation.stand_in_drive import with_stand_in_drive
from ...simulation.virtual_bench import virtual_bench
from .bench_limits import Limits, driven_limits, reached, widened
from .command_grid import Planned, command_grid
from .detection import Detection, Showing, listed, marginal, without_generic_bases
from .doubts import NOTHING, Doubt, Rival, information, reverses

_TURNS = 8  # half periods in a recording that are liked best
_FINALISTS = 8  # commands that are looked at again, without linearising
_FEW_FINALISTS = 2
_STEP = 1.25e-4  # own s of integration: a plan needs no more
_STEPS = 3  # of a rival's fit to what another would show
_RUNNERS_UP = 3
_SIDE_BY_SIDE = ThreadPoolExecutor(2)  # not that of side_by_side, which works for each of the commands

Pair = tuple[str, str]


@dataclass(frozen=True)
class Proposal:
    """A command to record next, and what it would tell."""

    command: str  # as ``simulate --command`` takes it
    seconds: float
    separation: Mapping[Pair, float]  # standard deviations by which each pair of rivals would come apart
    beyond: tuple[str, ...]  # what it would exceed of what the recordings have driven
    why: str
    shows: Mapping[str, tuple[float, float]]  # standard errors that hidden effects stand out by, so far and with it
    hides: tuple[str, ...] = ()  # effects that would not show even with it, though another recording would show them

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
    """The best command, if any decides or shows something, those that come after it, and what none can tell apart."""

    best: Proposal | None
    runners_up: tuple[Proposal, ...]
    inseparable: tuple[Pair, ...]
    so_far: Showing | None = None  # what the recordings so far show of other effects, where that is asked for


@dataclass(frozen=True, eq=False)
class _Explanation:
    """A rival with what the recordings so far leave open about it."""

    name: str
    hypothesis: Hypothesis
    information: np.ndarray  # (k, k) of its free numbers


@dataclass(frozen=True, eq=False)
class _Evaluated:
    trial: Planned
    done: Limits  # the furthest that a rival went
    separation: Mapping[Pair, float]
    information: np.ndarray | None = None  # that its recording adds, where it is asked for
    showing: Showing | None = None  # of effects, with the recordings so far


class _Field:
    """The rivals, the pairs of them that are to be told apart, and the bench that they are simulated on."""

    def __init__(
        self,
        problem: EquationErrorProblem,
        found: Fit,
        held: Sequence[Doubt],
        signals: frozenset[str],
        detection: Detection | None,
    ) -> None:
        self.base = found.hypothesis.base
        self.fits = [rival.fit for doubt in held for rival in doubt.rivals]
        self.found = id(found)
        self.detection = detection
        self.contenders: dict[int, _Explanation] = {}
        if detection is not None:
            self.contenders[id(found)] = _contender(problem, Rival(NOTHING, found))
        self.nested: set[Pair] = set()
        self.pairs: dict[Pair, tuple[int, int]] = {}  # by name; the first may be true, and the second, if not nested
        for doubt in held:
            known = zip(doubt.rivals, doubt.behind, strict=True)
            for (one, _), (other, behind) in itertools.combinations(known, 2):
                if one is not doubt.rivals[0] and behind > RIVAL_MARGIN:
                    continue  # neither is likely
                if _holds(other, one):  # the larger of nested ones first
                    one, other = other, one
                pair = self._named(one, other)
                self.pairs[pair] = (id(one.fit), id(other.fit))
                if _holds(one, other):
                    self.nested.add(pair)
            for rival in doubt.rivals:
                self.contenders.setdefault(id(rival.fit), _contender(problem, rival))
        of_torque = [o.torque_noise.min() for o in problem.observations if len(o.rows)]
        self.noise = float(np.median(of_torque)) if of_torque else math.nan  # what is not measured has none
        self.signals = signals
        self.reversed = reverses(problem)
        self.origins = (problem.observations[0].motor_origin, problem.observations[0].output_origin)

    def _named(self, one: Rival, other: Rival) -> Pair:
        """What a pair is called: of two effects of one kind beside the same rival, the second is numbered."""
        pair, number = (one.name, other.name), 2
        while self.pairs.get(pair, (id(one.fit), id(other.fit))) != (id(one.fit), id(other.fit)):
            pair, number = (f"{one.name}_{number}", other.name), number + 1
        return pair

    def grid(self, limits: Limits, *, few: bool) -> tuple[Planned, ...]:
        """The commands within limits."""
        ratio = self.base.value("machine.gear_ratio")
        gain = self.base.value("drive.position_gain") / ratio
        second, radian = (shown(self.base, 1.0, unit)[0] for unit in ("s", "rad"))
        return command_grid(limits, 2.0 * STANDSTILL / ratio, gain, few=few, second=second, radian=radian)

    def simulated(self, rival: int, trial: Planned) -> tuple[Observation, Limits]:
        """What a rival would show under a command, seen as the recordings are, and what the bench would reach."""
        model = with_stand_in_drive(self.contenders[rival].hypothesis.model())
        command = parse_command(trial.command)
        bench = virtual_bench(lumped_model(model), command, trial.seconds, seed=None, step=_STEP, origins=self.origins)
        seen = {name: values for name, values in bench.signals.items() if name in self.signals}
        o = observe(replace(bench, signals=seen), self.base)
        if len(o.rows):
            # the simulated current is free of noise: the bench's will be what it was
            o = replace(o, torque_noise=o.torque_noise * (self.noise / o.torque_noise.min()))
        return o, reached(o, model.value("machine.gear_ratio"))

    def evaluate(self, trial: Planned, limits: Limits) -> _Evaluated | None:
        """How far all pairs would come apart; None where a rival cannot do it or would leave the limits."""
        shown: dict[int, EquationErrorProblem] = {}
        furthest: Limits | None = None
        for rival in self.contenders:
            try:
                o, done = self.simulated(rival, trial)
            except InputError:
                return None  # the machine that this rival describes does not follow such a command
            if limits.effort(done) > 1.0:
                return None
            if furthest is None or limits.effort(done) > limits.effort(furthest):
                furthest = done
            shown[rival] = EquationErrorProblem([o])
        assert furthest is not None  # what was found is one of them, and a doubt has rivals
        adds = None if self.detection is None else self.detection.of(shown[self.found].observations[0])
        return _Evaluated(trial, furthest, self._separation(shown, 1), adds)

    def separation(self, trial: Planned, steps: int) -> dict[Pair, float]:
        """How far all pairs would come apart under a command that they can follow."""
        return self._separation(
            {rival: EquationErrorProblem([self.simulated(rival, trial)[0]]) for rival in self.contenders}, steps
        )

    def _separation(self, shown: Mapping[int, EquationErrorProblem], steps: int) -> dict[Pair, float]:
        found = {}
        for pair, (one, other) in self.pairs.items():
            found[pair] = self.apart(shown[one], one, other, steps)[0]
            if pair not in self.nested:  # what holds a rival and more can do all that the rival can
                found[pair] = min(found[pair], self.apart(shown[other], other, one, steps)[0])
        return found

    def apart(self, problem: EquationErrorProblem, true: int, other: int, steps: int) -> tuple[float, np.ndarray]:
        """(standard deviations, rows (m,)) by which a rival misses what a true one shows, at its best."""
        truth = problem.predict(self.contenders[true].hypothesis).rows
        contender = self.contenders[other]
        h, known = contender.hypothesis, contender.information
        even = np.ones(problem.rows)
        # each row counts by what the best of the rivals leaves over in rows of its kind
        cold = 1.0 / np.sqrt(np.min([f.row_temperatures_in(problem) for f in self.fits], axis=0))
        lower, upper = problem.bounds(h)
        moved = np.zeros(len(h.values))
        predicted = problem.predict(h)
        missed = problem.centred(truth - predicted.rows, even) * cold
        best, rows = float(missed @ missed), missed
        for _ in range(steps):
            slopes = jacobian(problem, h.at(contender.hypothesis.values + moved), predicted, even) * cold[:, None]
            a = slopes.T @ slopes + known
            scale = 1.0 / np.sqrt(np.maximum(np.diag(a), 1e-30))
            g = (slopes.T @ missed - known @ moved) * scale
            move = scale * np.linalg.solve(a * np.outer(scale, scale) + 1e-9 * np.eye(len(g)), g)
            if steps == 1:  # as far as straight lines tell
                left = missed - slopes @ move
                value = float(left @ left) + float(move @ known @ move)
                return (math.sqrt(max(value, 0.0)) if math.isfinite(value) else 0.0), left
            gained = False
            for share in (1.0, 0.3):
                trial = np.clip(contender.hypothesis.values + moved + share * move, lower, upper)
                p = problem.predict(h.at(trial))
                left = problem.centred(truth - p.rows, even) * cold
                away = trial - contender.hypothesis.values
                value = float(left @ left) + float(away @ known @ away)
                if value < best:
                    best, rows, moved, predicted, missed, gained = value, left, away, p, left, True
                    break
            if not gained:
                break
        return (math.sqrt(best) if math.isfinite(best) else 0.0), rows

    def why(self, e: _Evaluated, shows: Mapping[str, tuple[float, float]]) -> str:
        """A sentence: what would come apart, how far, and where in the recording; else what would show."""
        pair = next((p for p, value in e.separation.items() if value >= DECIDED), None)
        if pair is None:
            least = min(then for _, then in shows.values())
            return f"{listed([*shows])} of a usual size would show, by {least:.0f} standard errors or more"
        shown = []
        for true, rival in (self.pairs[pair], self.pairs[pair][::-1]):
            o, _ = self.simulated(true, e.trial)
            shown.append((o, self.apart(EquationErrorProblem([o]), true, rival, _STEPS)[1]))
        o, rows = max(shown, key=lambda entry: float(entry[1] @ entry[1]))
        other = "a model without it" if pair[1] == NOTHING else pair[1]
        novel = "" if self.reversed or not _turns(o) else "; no recording so far reverses"
        more = f". Besides, {listed([*shows])} of a usual size would show" if shows else ""
        return (
            f"{pair[0]} and {other} would come apart by {e.separation[pair]:.0f} standard deviations, "
            f"{_place(o, rows)}{novel}{more}"
        )


def _turns(o: Observation) -> bool:
    speed = o.motion[:, SPEED]
    return bool((speed > STANDSTILL).any() and (speed < -STANDSTILL).any())


def _place(o: Observation, rows: np.ndarray) -> str:
    """In which part of a recording most of a difference lies that is spread over rows (m,)."""
    power = rows**2
    count = len(o.rows)
    total = float(power.sum())
    if float(power[count:].sum()) > MOSTLY * total:
        return "between the encoders"
    power = power[:count]
    speed, time = o.motion[o.rows, SPEED], o.motion[o.rows, TIME]
    top = float(np.abs(speed).max())
    parts = {
        "while it moves backward": speed < 0.0,
        "while it moves forward": speed > 0.0,
        "where it is slow": np.abs(speed) < 0.5 * top,
        "where it is fast": np.abs(speed) > MOSTLY * top,
        "late in the run": time > 0.5 * time[-1],
        "early in the run": time < 0.5 * time[-1],
    }
    for name, part in parts.items():
        share = float(power[part].sum()) / total if total else 0.0
        if share > MOSTLY and share * len(part) > CLEARLY_MORE * max(int(part.sum()), 1):
            return f"mostly {name}"
    return "all along"


def _holds(one: Rival, other: Rival) -> bool:
    """Whether a rival has all effects of another, and more."""
    return {*one.fit.hypothesis.model().effects} > {*other.fit.hypothesis.model().effects}


def _contender(problem: EquationErrorProblem, rival: Rival) -> _Explanation:
    h = rival.fit.hypothesis
    # generic bases stand for what these recordings show, and say nothing of another
    physical = np.array([not free.path.startswith("basis.") for free in h.free])
    return _Explanation(rival.name, without_generic_bases(h), marginal(information(problem, rival.fit), physical))


def best_command(
    problem: EquationErrorProblem,
    found: Fit,
    held: Sequence[Doubt],
    signals: frozenset[str],
    *,
    detection: Detection | None = None,
    limits: Limits | None = None,
    few: bool = False,
    progress: Callable[[str], None] = lambda text: None,
) -> Choice:
    """The command that decides most of these doubts about what was ``found``, by the largest smallest separation.

    With ``detection``, of those the one that shows most of what the recordings so far do not show; there need be no
    doubt then. ``signals`` are those that the bench records, ``limits`` are in own units. Without them it stays within
    what the recordings have driven, unless only a command beyond that decides more doubts or shows more effects.
    ``few`` tries a handful only.
    """
    field = _Field(problem, found, held, signals, detection)
    allowed = limits or driven_limits(problem.observations, field.base.value("machine.gear_ratio"))
    tried = _evaluate_all(field, allowed, few, (), progress)
    if limits is None and (detection is not None or not any(_decides_all(e) for e in tried)):
        # whether more would show beyond is told by trying; what does not show at all in slow motion may take much
        # more speed than what is in doubt between rivals
        faster = LARGEST_EFFECT if detection is None else SEARCHED_UP_TO
        more = widened(allowed, field.base, field.origins[1], faster)
        tried += _evaluate_all(field, more, few, tried, progress)
    tried, so_far = _told_apart(field, tried)
    finalists = _varied(_ranked(tried, allowed, so_far))[: _FEW_FINALISTS if few else _FINALISTS]
    if field.pairs:
        progress("looking closer at the best commands")
        finalists = list(
            _SIDE_BY_SIDE.map(lambda e: replace(e, separation=field.separation(e.trial, _STEPS)), finalists)
        )
    ranked = _ranked(finalists, allowed, so_far)
    separable = {pair for e in (*tried, *finalists) for pair, value in e.separation.items() if value >= DECIDED}
    inseparable = tuple(pair for pair in field.pairs if pair not in separable)
    telling = [e for e in _varied(ranked) if _tells(e, so_far)]
    if not ranked or ranked[0] not in telling:
        there = None if field.reversed or not field.pairs else _there_and_back(field, allowed)
        return Choice(there, (), tuple(field.pairs), so_far)
    chosen = [ranked[0], *(e for e in telling if e is not ranked[0])]
    proposals = []
    for k, e in enumerate(chosen[: 1 + _RUNNERS_UP]):
        shows = _shows(e, so_far)
        beyond = allowed.shown(field.base).exceeded(e.done.shown(field.base)) if limits is None else ()
        why = field.why(e, shows) if k == 0 else ""
        hides = () if e.showing is None else e.showing.hidden()
        proposals.append(Proposal(e.trial.asked, e.trial.lasts, e.separation, beyond, why, shows, hides))
    return Choice(proposals[0], tuple(proposals[1:]), inseparable, so_far)


def _decides_all(e: _Evaluated) -> bool:
    """Whether a command decides all doubts."""
    return all(value >= DECIDED for value in e.separation.values())


def _told_apart(field: _Field, tried: Sequence[_Evaluated]) -> tuple[list[_Evaluated], Showing | None]:
    """The same commands with what each would show, and what the recordings so far do."""
    detection = field.detection
    if detection is None or not detection.effects or not tried:
        return list(tried), None
    apart = [detection.apart(detection.so_far + e.information) for e in tried if e.information is not None]
    matters = np.max(apart, axis=0) >= DECIDED
    told = [replace(e, showing=Showing(detection.effects, a, matters)) for e, a in zip(tried, apart, strict=True)]
    return told, Showing(detection.effects, detection.apart(detection.so_far), matters)


def _shows(e: _Evaluated, so_far: Showing | None) -> dict[str, tuple[float, float]]:
    """The effects that would stand out with a command and do not so far, the clearest first, and how far both times."""
    if so_far is None or e.showing is None:
        return {}
    found = {
        id: (float(now), float(then))
        for id, now, then in zip(so_far.effects, so_far.standing_out, e.showing.standing_out, strict=True)
        if now < SIGNIFICANT and then >= DECIDED
    }
    return dict(sorted(found.items(), key=lambda entry: -entry[1][1]))


def _tells(e: _Evaluated, so_far: Showing | None) -> bool:
    """Whether a command decides between rivals, or shows what is hidden so far."""
    return max(e.separation.values(), default=0.0) >= DECIDED or bool(_shows(e, so_far))


def _there_and_back(field: _Field, limits: Limits) -> Proposal | None:
    """A triangle, not faster and not further than half of what is allowed; no rival tells what it would show."""
    half = replace(limits, speed=0.5 * limits.speed, lower=0.5 * limits.lower, upper=0.5 * limits.upper)
    triangles = [trial for trial in field.grid(half, few=True) if trial.kind == "triangle"]
    if not triangles:
        return None
    trial = min(triangles, key=lambda trial: abs(trial.turns - _TURNS))
    return Proposal(trial.asked, trial.lasts, {}, (), "no recording reverses yet; the outcome cannot be predicted", {})


def _evaluate_all(
    field: _Field, limits: Limits, few: bool, before: Sequence[_Evaluated], progress: Callable[[str], None]
) -> list[_Evaluated]:
    """All commands of the grid that keep within limits and were not evaluated before."""
    known = {e.trial for e in before}
    trials = [trial for trial in field.grid(limits, few=few) if trial not in known]
    rivals = "" if len(field.contenders) < 2 else f" under {len(field.contenders)} rivals"
    progress(f"simulating {len(trials)} commands{rivals}")
    return [e for e in _SIDE_BY_SIDE.map(lambda trial: field.evaluate(trial, limits), trials) if e is not None]


def _ranked(found: Sequence[_Evaluated], allowed: Limits, so_far: Showing | None) -> list[_Evaluated]:
    """Best first: most pairs decided, then what keeps within limits, or decides or shows more than all that does.

    Of those what shows all effects best; where effects are not asked for, of the largest smallest separation. Among
    equals the gentlest.
    """
    separable = {pair for e in found for pair, value in e.separation.items() if value >= DECIDED}
    least = min((e.showing.named for e in found if e.showing is not None), default=0.0)

    gains = {e: (sum(value >= DECIDED for value in e.separation.values()), len(_shows(e, so_far))) for e in found}
    within = max((gains[e] for e in found if allowed.effort(e.done) <= 1.0), default=(0, 0))
    enough = all(gained <= within for gained in gains.values())

    def rank(e: _Evaluated) -> tuple[int, bool, float]:
        liked = allowed.effort(e.done) <= 1.0 if enough else gains[e] > within
        if e.showing is not None:
            return gains[e][0], liked, e.showing.named - least
        smallest = min((value for pair, value in e.separation.items() if pair in separable), default=0.0)
        return gains[e][0], liked, min(smallest, DECIDED**2)

    ranks = {e: rank(e) for e in found}
    left = sorted(found, key=ranks.__getitem__, reverse=True)
    ordered: list[_Evaluated] = []
    while left:
        most, liked, best = ranks[left[0]]
        share = MOSTLY if left[0].showing is None else NEARLY_ALL
        alike = [e for e in left if ranks[e][:2] == (most, liked) and ranks[e][2] >= share * best]
        # half of what was driven is gentle, and some turns average over what drifts
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


def _varied(ranked: Sequence[_Evaluated]) -> list[_Evaluated]:
    """The same, but the best of each kind of command first."""
    first = {e.trial.kind: e for e in reversed(ranked)}
    return sorted(ranked, key=lambda e: first[e.trial.kind] is not e)


def signals_of(recordings: Sequence[Recording]) -> frozenset[str]:
    """The signals that all recordings have."""
    return frozenset.intersection(*(frozenset(recording.signals) for recording in recordings))

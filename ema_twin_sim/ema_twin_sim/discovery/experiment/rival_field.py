"""How well a command separates rivals: each is simulated, and the others try to explain what it shows.

A rival may change every free number, as far as the recordings so far and its tolerance allow. The separation of two
rivals is what one still cannot explain of the other's simulated recording, plus the cost of changing its numbers. It is
in standard deviations of the noise and of what no rival explains.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ema_bench_replay.errors import InputError

from ...criteria import CLEARLY_MORE, DECIDED, MOSTLY, RIVAL_MARGIN, STANDSTILL
from ...identification.equation import EquationErrorProblem
from ...identification.fit import Fit
from ...identification.hypothesis import Hypothesis
from ...identification.jacobian import jacobian
from ...identification.uncertainty import linearised
from ...listing import listed
from ...measured.observation import Observation
from ...measured.observe import observe
from ...model.own_units import shown
from ...plant.motion import SPEED, TIME
from ...simulation.command import parse_command
from ...simulation.lumped_model import lumped_model
from ...simulation.stand_in_drive import with_stand_in_drive
from ...simulation.virtual_bench import virtual_bench
from .bench_limits import Limits, reached
from .command_grid import LONGEST, Planned, command_grid
from .detection import Detection, Showing, marginal
from .doubts import NOTHING, Doubt, Rival, reverses

_STEP = 1.25e-4  # own s, integration step: a plan needs no finer one
_AS_LONG = 2.0
"""None of the few commands lasts longer than this many times all recordings so far. A slow joint's own seconds are
minutes: a command of twenty takes longer to simulate than the search takes."""
STEPS = 3  # iterations of a rival's fit to what another would show

Pair = tuple[str, str]


@dataclass(frozen=True, eq=False)
class Explanation:
    """A rival, with how well the recordings so far determine it."""

    name: str
    hypothesis: Hypothesis
    information: np.ndarray  # (k, k) of its free numbers


@dataclass(frozen=True, eq=False)
class Evaluated:
    """A command, with the results of simulating it under all rivals."""

    trial: Planned
    done: Limits  # the limits reached by the rival that went furthest
    separation: Mapping[Pair, float]
    information: np.ndarray | None = None  # that its recording adds; None if not needed
    showing: Showing | None = None  # of effects, together with the recordings so far


class RivalField:
    """The rivals, the pairs to be separated, and the bench that they are simulated on."""

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
        self.contenders: dict[int, Explanation] = {}
        if detection is not None:
            self.contenders[id(found)] = _contender(Rival(NOTHING, found))
        self.nested: set[Pair] = set()
        self.pairs: dict[Pair, tuple[int, int]] = {}  # by name: (true, explaining); if not nested, also vice versa
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
                self.contenders.setdefault(id(rival.fit), _contender(rival))
        of_torque = [o.torque_noise.min() for o in problem.observations if len(o.rows)]
        self.noise = float(np.median(of_torque)) if of_torque else math.nan  # NaN if no torque was measured
        self.signals = signals
        self.reversed = reverses(problem)
        recorded = sum(float(o.motion[-1, TIME] - o.motion[0, TIME]) for o in problem.observations if not o.of_points)
        self.longest_of_few = min(LONGEST, _AS_LONG * recorded) if recorded else LONGEST
        self.origins = (problem.observations[0].motor_origin, problem.observations[0].output_origin)

    def _named(self, one: Rival, other: Rival) -> Pair:
        """Name of a pair; a second effect of the same kind against the same rival gets a number."""
        pair, number = (one.name, other.name), 2
        while self.pairs.get(pair, (id(one.fit), id(other.fit))) != (id(one.fit), id(other.fit)):
            pair, number = (f"{one.name}_{number}", other.name), number + 1
        return pair

    def grid(self, limits: Limits, *, few: bool) -> tuple[Planned, ...]:
        """The commands within limits."""
        longest = self.longest_of_few if few else LONGEST
        ratio = self.base.value("machine.gear_ratio")
        gain = self.base.value("drive.position_gain") / ratio
        second, radian = (shown(self.base, 1.0, unit)[0] for unit in ("s", "rad"))
        slowest = 2.0 * STANDSTILL / ratio
        return command_grid(limits, slowest, gain, few=few, longest=longest, second=second, radian=radian)

    def simulated(self, rival: int, trial: Planned) -> tuple[Observation, Limits]:
        """What a rival would show under a command, in the signals of the recordings, and what the bench would reach."""
        model = with_stand_in_drive(self.contenders[rival].hypothesis.model())
        command = parse_command(trial.command)
        bench = virtual_bench(lumped_model(model), command, trial.seconds, seed=None, step=_STEP, origins=self.origins)
        seen = {name: values for name, values in bench.signals.items() if name in self.signals}
        o = observe(replace(bench, signals=seen), self.base)
        if len(o.rows):
            # The simulated current has no noise: use that of the recordings.
            o = replace(o, torque_noise=o.torque_noise * (self.noise / o.torque_noise.min()))
        return o, reached(o, model.value("machine.gear_ratio"))

    def evaluate(self, trial: Planned, limits: Limits) -> Evaluated | None:
        """Separation of all pairs; None if a rival cannot follow the command or would exceed the limits."""
        shown: dict[int, EquationErrorProblem] = {}
        furthest: Limits | None = None
        for rival in self.contenders:
            try:
                o, done = self.simulated(rival, trial)
            except InputError:
                return None  # the machine of this rival cannot follow the command
            if limits.effort(done) > 1.0:
                return None
            if furthest is None or limits.effort(done) > limits.effort(furthest):
                furthest = done
            shown[rival] = EquationErrorProblem([o])
        assert furthest is not None  # the found explanation is a contender, and a doubt has rivals
        adds = None if self.detection is None else self.detection.of(shown[self.found])
        return Evaluated(trial, furthest, self._separation(shown, 1), adds)

    def separation(self, trial: Planned, steps: int) -> dict[Pair, float]:
        """Separation of all pairs under a command that they can follow."""
        return self._separation(
            {rival: EquationErrorProblem([self.simulated(rival, trial)[0]]) for rival in self.contenders}, steps
        )

    def _separation(self, shown: Mapping[int, EquationErrorProblem], steps: int) -> dict[Pair, float]:
        found = {}
        for pair, (one, other) in self.pairs.items():
            found[pair] = self.apart(shown[one], one, other, steps)[0]
            if pair not in self.nested:  # a larger nested rival can do all that the smaller can
                found[pair] = min(found[pair], self.apart(shown[other], other, one, steps)[0])
        return found

    def apart(self, problem: EquationErrorProblem, true: int, other: int, steps: int) -> tuple[float, np.ndarray]:
        """(standard deviations, rows (m,)) by which a rival misses what the true one shows, at its best fit."""
        truth = problem.predict(self.contenders[true].hypothesis).rows
        contender = self.contenders[other]
        h, known = contender.hypothesis, contender.information
        even = np.ones(problem.rows)
        # each row is scaled by what the best rival leaves in rows of its kind
        damped = 1.0 / np.sqrt(np.min([f.row_variance_inflations_in(problem) for f in self.fits], axis=0))
        lower, upper = problem.bounds(h)
        moved = np.zeros(len(h.values))
        predicted = problem.predict(h)
        missed = problem.centred(truth - predicted.rows, even) * damped
        best, rows = float(missed @ missed), missed
        for _ in range(steps):
            slopes = jacobian(problem, h.at(contender.hypothesis.values + moved), predicted, even) * damped[:, None]
            a = slopes.T @ slopes + known
            scale = 1.0 / np.sqrt(np.maximum(np.diag(a), 1e-30))
            g = (slopes.T @ missed - known @ moved) * scale
            move = scale * np.linalg.solve(a * np.outer(scale, scale) + 1e-9 * np.eye(len(g)), g)
            if steps == 1:  # linear estimate
                left = missed - slopes @ move
                value = float(left @ left) + float(move @ known @ move)
                return (math.sqrt(max(value, 0.0)) if math.isfinite(value) else 0.0), left
            gained = False
            for share in (1.0, 0.3):
                trial = np.clip(contender.hypothesis.values + moved + share * move, lower, upper)
                p = problem.predict(h.at(trial))
                left = problem.centred(truth - p.rows, even) * damped
                away = trial - contender.hypothesis.values
                value = float(left @ left) + float(away @ known @ away)
                if value < best:
                    best, rows, moved, predicted, missed, gained = value, left, away, p, left, True
                    break
            if not gained:
                break
        return (math.sqrt(best) if math.isfinite(best) else 0.0), rows

    def why(self, e: Evaluated, shows: Mapping[str, tuple[float, float]]) -> str:
        """A sentence: which pair separates, by how much, and where in the recording; else which effects would show."""
        pair = next((p for p, value in e.separation.items() if value >= DECIDED), None)
        if pair is None:
            least = min(then for _, then in shows.values())
            return f"{listed([*shows])} of a usual size would show, by {least:.0f} standard errors or more"
        shown = []
        for true, rival in (self.pairs[pair], self.pairs[pair][::-1]):
            o, _ = self.simulated(true, e.trial)
            shown.append((o, self.apart(EquationErrorProblem([o]), true, rival, STEPS)[1]))
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
    """The part of a recording that holds most of a difference, given as rows (m,)."""
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
    return "over the whole recording"


def _holds(one: Rival, other: Rival) -> bool:
    """Whether a rival has all effects of another, and more."""
    return {*one.fit.hypothesis.model().effects} > {*other.fit.hypothesis.model().effects}


def _contender(rival: Rival) -> Explanation:
    h = rival.fit.hypothesis
    physical = np.array([not free.path.startswith("basis.") for free in h.free])
    return Explanation(rival.name, h.without_generic_bases(), marginal(linearised(rival.fit).information, physical))

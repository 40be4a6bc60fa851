"""Diagnose: how likely each effect is the one that a model lacks, and how much of the error it removes.

The probability of an effect is the marginal probability that it is missing. Several effects may be missing at once;
each is then as probable as it is on its own. It comes from a block bootstrap over time, because the residual is
correlated: how often the effect would have won against its rivals and against no effect at all, had the recordings
consisted of other stretches of the same kind. Effects that the recordings cannot tell apart share one probability.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording

from ..comparison.running_comparison import RunningComparison, SignalError, excess_removed
from ..criteria import CLEARLY_MORE, SUREST
from ..effects import Kind, catalogue, kind_of
from ..identification.equation import EquationErrorProblem
from ..identification.estimates import shown_parameters
from ..identification.fit import Fit, fit
from ..identification.hypothesis import COMPLIANT_EFFECTS
from ..identification.uncertainty import held_out
from ..model import EffectInstance, Model
from ..model.own_units import in_si, shown_options
from ..parallel import simulations
from ..plant.motion import TIME
from ..simulation.compared_signals import ENCODER_DIFFERENCE
from ..simulation.encoder_difference import with_encoder_difference
from ..simulation.simulate import choose_input, simulate
from .criteria.worth import complexity_penalty, has_effect_size, noise_per_unit, penalised_gain
from .discover import Discovery, discover
from .errors_beside_curves import errors_beside_curves
from .search.rivals import loads_instead, substitutes
from .search.trace import Round, Trial, new_names

BLOCK = 2.0  # own s: stretches further apart than this count as independent
DRAWS = 400
RANKED = 8  # most entries of a ranking
SIMULATED = 4  # of these, entries whose error on unseen data is computed


@dataclass(frozen=True)
class Ranked:
    """One effect of a ranking.

    ``error_removed`` is the share of the excess error (above the sensors' noise) that it removes on data it was not
    fitted to. It is computed for the driving current (or unexplained torque) and for the output position, and the
    better of the two is given; None if it was not computed. ``found`` is whether the complete search holds the effect.
    """

    effect: str
    options: Mapping[str, str]
    probability: float
    error_removed: float | None
    parameters: Mapping[str, Mapping[str, object]]  # by name: value, std, unit
    found: bool


@dataclass(frozen=True)
class Diagnosis:
    """Which effects a model lacks; ``as_json`` is what ``diagnose --json`` writes."""

    verdict: str  # an effect's id, none or unknown
    ranking: tuple[Ranked, ...]  # found effects first, in discover's order; then the others, likeliest first
    none: float  # probability that no effect is missing
    unknown: float  # probability that something outside the ranking is missing
    groups: tuple[tuple[str, ...], ...]
    depends_on: tuple[str, ...]
    suggestion: Callable[[], str]  # of the next recording: computed when it is asked for, since it takes a while
    warnings: tuple[str, ...]
    beyond_noise: Mapping[str, float]  # by signal still above the noise at the end: how many times
    misread: tuple[str, ...] = ()  # the warnings that put all findings in doubt

    @property
    def next_recording(self) -> str:
        """What to record next, in a line that begins with the command; empty if nothing is in doubt."""
        return self.suggestion()

    def as_json(self) -> dict[str, object]:
        """SI units; missing numbers are null."""
        return {
            "verdict": self.verdict,
            "ranking": [
                {
                    "effect": entry.effect,
                    "options": dict(entry.options),
                    "probability": entry.probability,
                    "error_removed": entry.error_removed,
                    "parameters": {name: dict(value) for name, value in entry.parameters.items()},
                    "found": entry.found,
                }
                for entry in self.ranking
            ],
            "none": self.none,
            "unknown": self.unknown,
            "groups": [list(group) for group in self.groups],
            "depends_on": list(self.depends_on),
            "next_recording": self.next_recording,
            "warnings": list(self.warnings),
            "misread": list(self.misread),
            "beyond_noise": dict(self.beyond_noise),
        }


def diagnose(
    recordings: Sequence[Recording],
    model: Model,
    *,
    without: Sequence[str] = (),
    progress: Callable[[str], None] = lambda text: None,
) -> Diagnosis:
    """Rank the effects that a model may lack, given recordings of its machine.

    ``without`` excludes effects of the catalogue; ``progress`` is called with a description of each stage. Raises
    InputError if the recordings cannot be judged.
    """
    found = discover(recordings, model, without=without, progress=progress)
    progress("computing probabilities")
    return weigh(found)


@dataclass(frozen=True, eq=False)
class _Contender:
    """An effect that may be missing: the fits without it and with it."""

    name: str
    before: Fit
    after: Fit

    @property
    def instance(self) -> EffectInstance:
        return self.after.hypothesis.instance(self.name)

    @property
    def key(self) -> Kind:
        return kind_of(self.instance.effect, self.instance.options)


def weigh(found: Discovery) -> Diagnosis:
    """The diagnosis that follows from a discovery."""
    problem = found.equation
    tried = [contender for turn in found.search.rounds for trial in turn.tried for contender in _added(turn, trial)]
    contests = _contests(problem, found)
    causes = [cause for cause, *_ in contests]
    held = {cause.key: penalised_gain(cause.before, cause.after) for cause in causes}
    if not contests and found.verdict != "unknown":
        # what gains and is not held was dropped, itself or as a rival: the search had reasons beyond its gain
        alone = [c for c in tried if len(new_names(c.before, c.after)) == 1]
        contests = [[c for c in alone if penalised_gain(c.before, c.after) <= 0.0]]
    absent: dict[Kind, float] = {contender.key: 1.0 for contender in tried} | dict.fromkeys(held, 1.0)
    nothing = float(found.verdict != "unknown")
    for contest in contests:
        without = 0.0
        chances: dict[Kind, float] = {}
        for winner, chance in _chances(problem, contest, bool(held)):
            if winner is None:
                without += chance
            else:
                chances[winner.key] = chances.get(winner.key, 0.0) + chance
        nothing *= without
        for key, chance in _shared(contest, chances, found).items():
            absent[key] = absent.get(key, 1.0) * (1.0 - chance)
    present = {key: SUREST * (1.0 - chance) for key, chance in absent.items()}
    contenders = {contender.key: contender for contender in reversed([c for each in contests for c in each] + tried)}
    # an effect that the search holds is reported with the numbers of the final model
    contenders |= {cause.key: replace(cause, after=found.search.fit) for cause in causes}
    likeliest = sorted(present, key=lambda key: (-present[key], -held.get(key, 0.0)))
    order = [key for place, key in enumerate(likeliest) if place < RANKED or key in held]
    removed = _removed(problem, found, [contenders[key] for key in order[:SIMULATED]])
    order.sort(key=lambda key: _place(found, key, held))
    ranking = tuple(_ranked(problem, contenders[key], present[key], removed.get(key), key in held) for key in order)
    verdict = next(entry.effect for entry in ranking if entry.found) if found.verdict == "explained" else found.verdict
    return Diagnosis(
        verdict,
        ranking,
        SUREST * nothing,
        SUREST if found.verdict == "unknown" else 1.0 - SUREST,
        found.groups,
        found.depends_on,
        lambda: found.next_recording,
        found.warnings,
        found.beyond_noise,
        found.misread,
    )


def _place(found: Discovery, key: Kind, held: Container[Kind]) -> int:
    """Sort key: found effects first, in discover's order; the others keep their order."""
    return found.added.index(key[0]) if key in held and key[0] in found.added else len(found.added)


def _contests(problem: EquationErrorProblem, found: Discovery) -> list[list[_Contender]]:
    """For each effect that the complete search holds: the effect, and what could replace it."""
    best = found.search.free_fit
    contests: dict[Kind, list[_Contender]] = {}
    for name, instance in best.hypothesis.added.items():
        bare = fit(problem, best.hypothesis.without(name), 4, known=best)
        contest = [_Contender(name, bare, best)]
        turn = next((turn for turn in found.search.taken if name in turn.added), None)
        if turn is not None and instance.effect not in COMPLIANT_EFFECTS:
            rivals = substitutes(best, name, turn)
            rivals += loads_instead(best, name, frozenset(catalogue()) - _compared(found, instance.effect))
            contest += [_Contender(list(rival.hypothesis.added)[-1], bare, rival) for rival in rivals]
        contests.setdefault(contest[0].key, contest)
    return list(contests.values())


def _compared(found: Discovery, effect: str) -> set[str]:
    """The effects that the search compared with one that it holds."""
    fits = [f for rivalry in found.rivalries if rivalry.effect == effect for f in rivalry.fits]
    return {list(f.hypothesis.added.values())[-1].effect for f in fits if f.hypothesis.added}


def _shared(contest: Sequence[_Contender], chances: dict[Kind, float], found: Discovery) -> dict[Kind, float]:
    """The chances of a contest, with those of effects that share a reported group divided by their odds.

    Which of them explains a little more is no evidence: nearly every draw would count for the same one.
    """
    if not contest:
        return chances
    cause = contest[0].key[0]
    odds = {cause: 1.0}
    for rivalry in found.rivalries:
        if rivalry.effect == cause and rivalry.group in found.groups:
            odds |= rivalry.close
    alike: dict[str, Kind] = {}
    for key in sorted((c.key for c in contest), key=lambda key: -chances.get(key, 0.0)):
        if key[0] in odds:
            alike.setdefault(key[0], key)
    together, all_odds = sum(chances.get(key, 0.0) for key in alike.values()), sum(odds[id] for id in alike)
    return chances | {key: together * odds[id] / all_odds for id, key in alike.items()}


def _added(turn: Round, trial: Trial) -> list[_Contender]:
    """The effects that a trial adds; empty if it adds a generic basis."""
    return [_Contender(n, turn.before, trial.fit) for n in trial.names if n in trial.fit.hypothesis.added]


def _chances(
    problem: EquationErrorProblem, contest: Sequence[_Contender], held: bool
) -> list[tuple[_Contender | None, float]]:
    """How often (0 to 1) each contender gains most, and how often none gains anything, over draws of blocks."""
    # The search holds the first contender together with all others: its effect size was checked there.
    entries = [c for k, c in enumerate(contest) if (k == 0 and held) or has_effect_size(problem, c.before, c.after)]
    if not entries:
        return [(None, 1.0)]
    blocks = _blocks(problem)
    count = int(blocks.max()) + 1
    drawn = np.random.default_rng(0).multinomial(count, np.full(count, 1.0 / count), DRAWS)
    table = np.zeros((DRAWS, len(entries) + 1))
    for column, contender in enumerate(entries):
        before, after = contender.before, contender.after
        noise = np.repeat(noise_per_unit(before, after), (problem.size, problem.rows - problem.size))
        fall = np.bincount(blocks, (before.problem.costs(before.raw) - after.problem.costs(after.raw)) / noise)
        table[:, column] = drawn @ fall - (complexity_penalty(after) - complexity_penalty(before))
    wins = np.bincount(np.argmax(table, axis=1), minlength=len(entries) + 1) / DRAWS
    return [(entry, float(share)) for entry, share in zip([*entries, None], wins, strict=True) if share > 0.0]


def _blocks(problem: EquationErrorProblem) -> np.ndarray:
    """Block index (m,) of each row: a stretch of time, for torque and encoder alike, or an operating point."""
    found = np.zeros(problem.rows, int)
    first = 0
    for o, torque, encoder in zip(problem.observations, problem.torque_parts, problem.encoder_parts, strict=True):
        time = o.motion[:, TIME] - o.motion[0, TIME]
        blocks = np.arange(len(time)) if o.of_points else (time / BLOCK).astype(int)
        found[torque] = first + blocks[o.rows]
        found[encoder] = first + blocks[o.encoder_rows]
        first += int(blocks[-1]) + 1
    return np.unique(found, return_inverse=True)[1]


def _ranked(
    problem: EquationErrorProblem, contender: _Contender, probability: float, removed: float | None, found: bool
) -> Ranked:
    f, instance = contender.after, contender.instance
    parameters = shown_parameters(f.hypothesis.base, contender.name, instance, errors_beside_curves(problem, f))
    options = shown_options(f.hypothesis.base, instance.options)
    return Ranked(instance.effect, options, probability, removed, parameters, found)


def _removed(problem: EquationErrorProblem, found: Discovery, contenders: Sequence[_Contender]) -> dict[Kind, float]:
    """Share of the excess error that each contender removes on recordings it was not fitted to."""
    fits = {id(f): f for contender in contenders for f in (contender.before, contender.after)}
    if not contenders:
        return {}
    recordings, base = found.recordings, contenders[0].before.hypothesis.base
    sources = [choose_input(recording, base) for recording in recordings]
    jobs = []
    for key, f in fits.items():
        numbers, _ = held_out(problem, f)
        models = [in_si(f.hypothesis.at(values).model()) for values in numbers]
        jobs += [(key, *job) for job in zip(recordings, sources, models, strict=True)]

    def error(job: tuple[int, Recording, str, Model]) -> RunningComparison | None:
        _, recording, source, model = job
        compared = RunningComparison(model, source, period=recording.sample_period, noise=found.noise)
        try:
            twin = simulate(model, recording, source)
            compared.add_rows(*with_encoder_difference(model, recording, source, twin))
        except InputError:  # the loop cannot be simulated with these numbers: not computed for this contender
            return None
        return compared

    errors: dict[int, RunningComparison | None] = {}
    for (key, _, _, model), compared in zip(jobs, simulations(error, jobs), strict=True):
        driving = sources[0] if len(set(sources)) == 1 else "current"
        pooled = errors.setdefault(key, RunningComparison(model, driving, noise=found.noise))
        if compared is None or pooled is None:
            errors[key] = None
        else:
            pooled.include(compared)
    shares = {}
    for contender in contenders:
        before, after = errors[id(contender.before)], errors[id(contender.after)]
        if before is not None and after is not None:
            shares[contender.key] = _share(before.result(), after.result(), before.source)
    return shares


def _share(before: Mapping[str, SignalError], after: Mapping[str, SignalError], source: str) -> float:
    """Largest share (0 to 1) of a signal's excess error that was removed; 0 if no error is above the noise."""
    telling = ("unexplained_torque", ENCODER_DIFFERENCE) if source == "current" else ("current", "output_position")
    shares = [
        excess_removed(before[name], after[name])
        for name in telling
        if name in before and before[name]["rmse"] > CLEARLY_MORE * before[name]["noise_floor"]
    ]
    return max((share for share in shares if share is not None), default=0.0)

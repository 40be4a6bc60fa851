"""Doubts: explanations that the recordings leave open, each as a hypothesis that can be simulated.

A found effect is in doubt if something else in its place explains the recordings nearly as well: another effect,
another kind of the same, or only constants within their tolerance. An effect that was too small to be named is in doubt
as well. So is a load if no recording reverses, found or not.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...criteria import FAR_OUT, LEAST_SIZE, LIKELY, NEGLIGIBLE, SIGNIFICANT, STANDSTILL
from ...effects import Trait, catalogue, effects_with
from ...identification.candidates import Candidate, candidates
from ...identification.equation import EquationErrorProblem
from ...identification.fit import Fit, fit
from ...identification.hypothesis import COMPLIANT_EFFECTS, Hypothesis
from ...identification.screening import screen
from ...identification.uncertainty import linearised
from ...model import EffectInstance
from ...plant.motion import SPEED
from ..criteria.worth import ENCODER_ONLY, penalised_gain
from ..search.adding import entrants
from ..search.rivals import Rivalry
from ..search.trace import Search

ALTERNATIVES = 3
"""Explanations that are compared with a found effect."""
NOTHING = "none"


@dataclass(frozen=True, eq=False)
class Rival:
    """One explanation of all recordings: its name among its rivals, and its fit."""

    name: str  # an effect with its kind, or ``none``
    fit: Fit


@dataclass(frozen=True, eq=False)
class Doubt:
    """Rivals between which the recordings do not decide, the leading one first."""

    rivals: tuple[Rival, ...]
    behind: tuple[float, ...]  # how far behind the first, penalties included, in noise units
    reason: str

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the rivals."""
        return tuple(rival.name for rival in self.rivals)


def doubts(
    problem: EquationErrorProblem,
    found: Search,
    rivals: Sequence[Rivalry],
    without: frozenset[str] = frozenset(),
    *,
    thorough: bool = True,
) -> tuple[Doubt, ...]:
    """What the recordings of ``problem`` leave in doubt after a search and the comparison with its rivals.

    ``thorough`` compares every effect of the catalogue with each found one, instead of only its known rivals. It is
    ignored for a model with backlash or compliance, where that would take too long.
    """
    best = found.fit
    standing = {rivalry.effect: rivalry for rivalry in rivals}
    held = []
    for name, instance in best.hypothesis.added.items():
        if instance.effect in COMPLIANT_EFFECTS:
            continue  # decided by the encoder difference
        wanted: set[str] = set()
        fits: tuple[Fit, ...] = ()
        if instance.effect in standing:
            rivalry = standing[instance.effect]
            fits = tuple(f for f in rivalry.fits if name not in f.hypothesis.added)
            wanted = {*rivalry.group} - {instance.effect}
            if rivalry.behind < SIGNIFICANT**2:
                wanted.add(rivalry.runner_up)
        if thorough and not best.parted:  # a gearbox takes too long to try every effect
            wanted |= {*catalogue()} - {instance.effect, *ENCODER_ONLY}
        doubt = _about(problem, best, name, wanted, without, fits)
        if doubt is not None:
            held.append(doubt)
    doubt = _too_small(found)
    if doubt is not None:
        held.append(doubt)
    if not reverses(problem):
        doubt = _one_direction(problem, best, without, {n.partition("(")[0] for d in held for n in d.names})
        if doubt is not None:
            held.append(doubt)
    return tuple(held)


def reverses(problem: EquationErrorProblem) -> bool:
    """Whether more than a negligible share of the recorded motion is in the other direction."""
    forward, backward = _ways(problem)
    return min(forward, backward) > NEGLIGIBLE * (forward + backward)


def moves_one_way(problem: EquationErrorProblem) -> bool:
    """Whether something moves, and nothing reverses; operating points may all be held at standstill."""
    return any(_ways(problem)) and not reverses(problem)


def _ways(problem: EquationErrorProblem) -> tuple[float, float]:
    """How long [own s] the motor turns forwards and backwards."""
    forward = sum(float(np.sum(o.motion[:, SPEED] > STANDSTILL)) * o.period for o in problem.observations)
    backward = sum(float(np.sum(o.motion[:, SPEED] < -STANDSTILL)) * o.period for o in problem.observations)
    return forward, backward


def _about(
    problem: EquationErrorProblem, best: Fit, name: str, wanted: set[str], without: frozenset[str], fits: Sequence[Fit]
) -> Doubt | None:
    """The doubt about a found effect: its close alternatives, no effect included; ``fits`` are already fitted ones."""
    instance = best.hypothesis.added[name]
    kinds = _other_kinds(best.hypothesis, name, without)
    if not (wanted or kinds or fits or _may_be_nothing(best, name)):
        return None
    bare = fit(problem, best.hypothesis.without(name), 4, known=best)
    tried = list(fits)
    if wanted:
        excluded = without | (frozenset(catalogue()) - wanted)
        tried += [fit(problem, h, 6, known=bare) for h in entrants(problem, bare, excluded)[:ALTERNATIVES]]
    for s in screen(problem, bare, kinds):
        h = bare.hypothesis.with_effect(s.candidate.effect, s.candidate.options, s.start)
        tried.append(fit(problem, h, 6, known=bare))
    others = {
        _last(f).effect: f
        for f in sorted(tried, key=lambda f: penalised_gain(best, f))
        if _last(f).effect != instance.effect
    }
    alike = [f for f in tried if _last(f).effect == instance.effect]
    rivals = [Rival(NOTHING, bare), *(Rival(id, f) for id, f in others.items())]
    rivals += [Rival(_in_full(_last(f)), f) for f in alike]
    behind = [(-penalised_gain(best, rival.fit), rival) for rival in rivals]
    near = sorted((entry for entry in behind if entry[0] < SIGNIFICANT**2), key=lambda entry: entry[0])[:ALTERNATIVES]
    if not near:
        return None
    own = _in_full(instance) if any(rival.fit in alike for _, rival in near) else instance.effect
    instead = " or ".join(
        "constants within their tolerance alone" if rival.name == NOTHING else rival.name for _, rival in near
    )
    return Doubt(
        (Rival(own, best), *(rival for _, rival in near)),
        (0.0, *(loss for loss, _ in near)),
        f"{instead} would explain the recordings nearly as well as {own}",
    )


def _last(f: Fit) -> EffectInstance:
    return list(f.hypothesis.added.values())[-1]


def _in_full(instance: EffectInstance) -> str:
    return Candidate(instance.effect, instance.options).name


def _other_kinds(h: Hypothesis, name: str, without: frozenset[str]) -> list[Candidate]:
    """The same effect with one option different; numeric options are excluded, since they show by themselves."""
    instance = h.added[name]
    excluded = without | (frozenset(catalogue()) - {instance.effect})

    def differs_in_kind(options: dict[str, str]) -> bool:
        changed = [k for k, v in options.items() if v != instance.options.get(k)]
        return len(changed) == 1 and not options[changed[0]].replace(".", "").isdigit()

    return [c for c in candidates(h.without(name), excluded) if differs_in_kind(dict(c.options))]


def _may_be_nothing(best: Fit, name: str) -> bool:
    """Whether an effect's size is so uncertain that the recordings may be explained without it."""
    size = catalogue()[best.hypothesis.added[name].effect].parameters[0]
    if size.neutral is None:
        return False
    paths = [free.path for free in best.hypothesis.free]
    k = paths.index(f"effects.{name}.{size.name}")
    spread = np.linalg.pinv(linearised(best).information, hermitian=True)[k, k]
    return (best.hypothesis.values[k] - size.neutral) ** 2 < FAR_OUT**2 * float(spread)


def _too_small(found: Search) -> Doubt | None:
    """The doubt about an effect that was worth its penalty but too small to be named.

    None with generic bases or an output that bounces: there such an effect is part of what no effect explains.
    """
    best = found.fit
    if found.stopped is None or best.hypothesis.generic_bases or best.parted:
        return None
    needed = 0.5 * LEAST_SIZE * math.sqrt(max(1.0, best.variance_inflation / best.problem.correlation))
    for trial in found.stopped.tried:
        new = [n for n in trial.fit.hypothesis.added if n not in best.hypothesis.added]
        if trial.gain > 0.0 and trial.unique > needed and len(new) == 1:
            name = trial.fit.hypothesis.added[new[0]].effect
            small = (
                "is too small beside the noise" if trial.unique < 2.0 * needed else "explains too little of the error"
            )
            reason = f"{name} shows, but {small} to be named"
            return Doubt((Rival(NOTHING, best), Rival(name, trial.fit)), (0.0, -trial.gain), reason)
    return None


def _one_direction(problem: EquationErrorProblem, best: Fit, without: frozenset[str], named: set[str]) -> Doubt | None:
    """The doubt left by recordings in one direction: slightly less friction, with a load that makes up for it."""
    alike = effects_with(Trait.SHOWN_BY_REVERSALS)
    if best.hypothesis.held & alike or named & alike:
        return None
    id = min(alike - without, key=lambda id: (id not in effects_with(Trait.LOAD), id), default=None)
    if id is None:
        return None
    rival = Rival(id, _as_large_as_may_be(problem, best, id))
    reason = f"no recording reverses, and in one direction {id} looks like friction that is off by a little"
    return Doubt((Rival(NOTHING, best), rival), (0.0, -penalised_gain(best, rival.fit)), reason)


def _as_large_as_may_be(problem: EquationErrorProblem, best: Fit, id: str) -> Fit:
    """Fit with an effect as large as the recordings allow; the constants adjust to it."""
    size = catalogue()[id].parameters[0]
    free = fit(problem, best.hypothesis.with_effect(id, {}, {size.name: 1e-3 * size.default}), 4, known=best)
    k = [f.path for f in free.hypothesis.free].index(f"effects.{id}.{size.name}")
    spread = math.sqrt(float(np.linalg.pinv(linearised(free).information, hermitian=True)[k, k]))
    value = free.hypothesis.values[k] + math.copysign(LIKELY * spread, free.hypothesis.values[k])
    base = best.hypothesis.base.with_effect(id, {size.name: min(max(value, size.lower), size.upper)})
    return fit(problem, replace(best.hypothesis, base=base), 4, known=best)

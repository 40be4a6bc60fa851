"""Rivals: what could stand in for a found effect and explain the recordings as well."""

from __future__ import annotations

from dataclasses import dataclass

from .equation import Equation, Fit, fit
from .search import entrants, gain, unique

CLOSE = 8.0  # price paid, in units of noise: a rival that loses by less cannot be told from the effect
TRIED = 3


@dataclass(frozen=True, eq=False)
class Rivalry:
    """One found effect, the best that could stand in for it, and those that the data cannot tell from it."""

    effect: str
    runner_up: str
    behind: float  # how much the runner-up loses by
    group: tuple[str, ...]  # the effect and what the data cannot tell from it, sorted


def rivalries(eq: Equation, best: Fit, without: frozenset[str]) -> tuple[Rivalry, ...]:
    """For each found effect, refit without it and with its best substitutes."""
    found = []
    for name, instance in best.hypothesis.added.items():
        if best.predicted.plant["two_inertia"][0] != 0.0 and instance.effect in ("backlash", "shaft_compliance"):
            continue
        bare = fit(eq, best.hypothesis.without(name), 4, known=best)
        barred = without | {instance.effect}
        substitutes = [fit(eq, h, 6, known=bare) for h in entrants(eq, bare, barred)[:TRIED]]
        if not substitutes:
            continue
        ranked = sorted(substitutes, key=lambda f: -gain(eq, best, f))
        close = {
            list(f.hypothesis.added.values())[-1].effect
            for f in ranked
            if gain(eq, best, f) > -CLOSE and unique(eq, bare, f) > 0.0
        }
        runner_up = list(ranked[0].hypothesis.added.values())[-1].effect
        group = tuple(sorted({instance.effect, *close}))
        found.append(Rivalry(instance.effect, runner_up, -gain(eq, best, ranked[0]), group))
    return tuple(found)

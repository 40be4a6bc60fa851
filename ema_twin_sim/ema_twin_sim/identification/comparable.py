"""Comparable fits: to the same rows under one weighting. Misfits under different weightings do not compare."""

from __future__ import annotations

import math
from collections.abc import Iterable

from .equation import EquationErrorProblem
from .fit import Fit, fit


class DifferentWeightings(AssertionError):
    """Fits under different weightings were compared: an error of the caller."""


def refuse_different_weightings(one: Fit, other: Fit) -> None:
    """Raise DifferentWeightings if the misfits of two fits do not compare."""
    if not one.problem.compares_with(other.problem):
        raise DifferentWeightings(
            f"fits with {_named(one)} and with {_named(other)} stand under different weightings; fit one of them again"
        )


def cheapest(fits: Iterable[Fit]) -> Fit:
    """The fit (of one or more) with the lowest cost; the first of equals; non-finite costs come last."""
    first, *others = fits
    for other in others:
        refuse_different_weightings(first, other)
    return min((first, *others), key=lambda f: f.cost if math.isfinite(f.cost) else math.inf)


def costs_no_more(one: Fit, other: Fit, share: float = 1.0) -> bool:
    """Whether one fit costs no more than ``share`` times another."""
    refuse_different_weightings(one, other)
    return one.cost <= share * other.cost


def as_compares(f: Fit, problem: EquationErrorProblem) -> Fit:
    """A fit that compares with those to a problem: itself, or refitted if its weighting differs."""
    return f if f.problem.compares_with(problem) else fit(problem, f.hypothesis)


def _named(f: Fit) -> str:
    return " and ".join(f.hypothesis.effects) or "no effect"


def by_chance(numbers: int) -> float:
    """Gain of additional parameters by chance, in units of the remaining noise: at most two each."""
    return 2.0 * numbers

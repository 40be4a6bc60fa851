"""Detection: by how many standard errors recordings would show each effect of the catalogue at its typical size.

To first order in all sizes, a recording contributes Fisher information about the sizes of all effects and the free
numbers of the explanation. The information of several recordings adds up, so that of a planned command is added to that
of the recordings so far. An effect stands out by what neither the free numbers nor any one other effect, of any size,
can compensate. The shape parameters of an effect are held at their typical values.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...criteria import DECIDED, SIGNIFICANT, UNSEEN_SPREAD
from ...effects import catalogue
from ...identification.candidates import candidates
from ...identification.equation import EquationErrorProblem
from ...identification.fit import Fit, prior_rows
from ...identification.hypothesis import COMPLIANT_EFFECTS, Hypothesis
from ...identification.jacobian import jacobian
from ...identification.prediction import Prediction
from ...identification.screening import STEP
from ...identification.start_values import regressed_angle
from ...model import EffectInstance
from ...model.own_units import table_in


def share_told(apart: float) -> float:
    """Share (0 to 1) of one explanation told from another by so many standard errors: one half at DECIDED."""
    return float(apart**2 / (apart**2 + DECIDED**2))


@dataclass(frozen=True, eq=False)
class Showing:
    """Separation of effects (n, n): standard errors of each, at its typical size, from each other of any size.

    The diagonal holds the separation from no effect, with the explanation's free numbers. ``matters`` (n, n) marks
    pairs that some recording within reach would separate: what none separates is no reason to prefer one recording.
    """

    effects: tuple[str, ...]
    apart: np.ndarray
    matters: np.ndarray

    @property
    def named(self) -> float:
        """Expected number of effects that would be named if each were there, one at a time.

        Each counts as a share: one half if it stands out from its worst rival by DECIDED.
        """
        return sum(share_told(value) for value in self.standing_out)

    @property
    def standing_out(self) -> np.ndarray:
        """Standard errors (n,) by which each effect differs from its closest rival, or from no effect."""
        worst = np.min(np.where(self.matters, self.apart, math.inf), axis=1, initial=math.inf)
        return np.where(np.isfinite(worst), worst, 0.0)

    def of(self, effect: str, other: str = "") -> float:
        """Standard errors of an effect from another, or from no effect."""
        k = self.effects.index(effect)
        return float(self.apart[k, self.effects.index(other) if other else k])

    def hidden(self) -> tuple[str, ...]:
        """Effects that would not show clearly enough to be named, although other recordings would show them."""
        shown = np.diag(self.apart)
        within_reach = np.diag(self.matters)
        return tuple(id for k, id in enumerate(self.effects) if within_reach[k] and shown[k] < SIGNIFICANT)

    def confused(self) -> dict[str, tuple[str, ...]]:
        """By effect that shows: others that show and look like it, although other recordings would separate them.

        Each pair is listed once.
        """
        shown = np.diag(self.apart) >= SIGNIFICANT
        either_way = self.matters | self.matters.T
        alike = either_way & (np.minimum(self.apart, self.apart.T) < SIGNIFICANT) & np.outer(shown, shown)
        rows = {id: np.flatnonzero(row) for id, row in zip(self.effects, np.triu(alike, 1), strict=True)}
        return {id: tuple(self.effects[n] for n in row) for id, row in rows.items() if len(row)}


@dataclass(frozen=True)
class _Column:
    """An effect at one angle, a small step of its typical size from its neutral value."""

    effect: str
    instance: EffectInstance
    second: bool  # whether it is the second of two angles


class Detection:
    """The effects that may be added to an explanation, and how clearly recordings would show them."""

    def __init__(self, found: Fit, excluded: frozenset[str]) -> None:
        self.hypothesis = found.hypothesis.without_generic_bases()
        self._found = found
        self._columns = _columns(found.hypothesis, excluded)
        self.effects = tuple(dict.fromkeys(column.effect for column in self._columns))
        _, priors = prior_rows(found.hypothesis)
        rows = self._rows(found.problem, found.hypothesis, found.predicted, found.weights, found.jacobian)
        information = _information(rows, found.row_variance_inflations)
        count = len(found.hypothesis.free)
        information[:count, :count] += priors.T @ priors
        physical = [not free.path.startswith("basis.") for free in found.hypothesis.free]
        self.so_far = marginal(information, np.array([*physical, *(True for _ in self._columns)]))

    def of(self, problem: EquationErrorProblem) -> np.ndarray:
        """Information (m, m) that the recordings of a problem add about the free numbers and the sizes of all effects.

        Wandering friction in new recordings is ignored, because how it wanders is only found by a fit to measured
        data. For a machine with wandering friction the result is slightly too optimistic.
        """
        even = np.ones(problem.rows)
        predicted = problem.predict(self.hypothesis)
        slopes = jacobian(problem, self.hypothesis, predicted, even)
        rows = self._rows(problem, self.hypothesis, predicted, even, slopes)
        return _information(rows, self._found.row_variance_inflations_in(problem))

    def apart(self, information: np.ndarray) -> np.ndarray:
        """Standard errors (n, n) as in ``Showing``; for an effect with a free angle, at the angle that shows least."""
        sizes = marginal(information, np.arange(len(information)) >= len(self.hypothesis.free))
        # an effect with one column gets a second that is perfectly known and unlike all others
        count = len(self.effects)
        places = [2 * self.effects.index(c.effect) + c.second for c in self._columns]
        full = np.diag(np.where(np.isin(np.arange(2 * count), places), 0.0, 1e30))
        full[np.ix_(places, places)] = sizes
        blocks = full.reshape(count, 2, count, 2).transpose(0, 2, 1, 3)  # (n, n, 2, 2)
        own = blocks[np.arange(count), np.arange(count)]
        held = np.linalg.inv(own + np.eye(2) / UNSEEN_SPREAD**2)
        lost = np.einsum("knab,nbc,kndc->knad", blocks, held, blocks)
        lost[np.arange(count), np.arange(count)] = 0.0
        least = np.linalg.eigvalsh(own[:, None] - lost)[:, :, 0]
        return np.asarray(np.sqrt(np.maximum(least, 0.0)))

    def _rows(
        self,
        problem: EquationErrorProblem,
        h: Hypothesis,
        predicted: Prediction,
        weights: np.ndarray,
        slopes: np.ndarray,
    ) -> np.ndarray:
        """Weighted rows (m, k): slopes of the free numbers, then every effect at its typical size."""
        found = []
        for column in self._columns:
            rows = problem.beside(h, predicted, column.instance)
            if rows is None:
                more = h.with_effect(column.effect, column.instance.options, column.instance.parameters)
                rows = problem.centred(problem.predict(more).rows - predicted.rows, weights)
            found.append(np.nan_to_num(rows * weights / STEP, nan=0.0, posinf=0.0, neginf=0.0))
        return np.column_stack([slopes, *found])


def _information(rows: np.ndarray, variance_inflations: np.ndarray) -> np.ndarray:
    """Information (k, k) of rows (m, k), reduced by their variance inflations (m,)."""
    scaled = rows / np.sqrt(variance_inflations)[:, None]
    return np.asarray(scaled.T @ scaled)


def _columns(h: Hypothesis, excluded: frozenset[str]) -> tuple[_Column, ...]:
    """The effects that may be added, with default options; two angles for an effect with a free angle."""
    found: list[_Column] = []
    for c in candidates(h, excluded | set(COMPLIANT_EFFECTS) | h.held):
        effect = table_in(catalogue()[c.effect], h.base.units)
        size, turning = effect.parameters[0], regressed_angle(effect)
        if c.options != effect.default_options() or size.neutral is None or size.default == size.neutral:
            continue  # no information about an effect that is not proportional to its size
        small = {**effect.default_parameters(), size.name: size.neutral + STEP * (size.default - size.neutral)}
        angles = [{}] if turning is None else [{turning.name: 0.0}, {turning.name: 0.5 * math.pi}]
        found += [
            _Column(c.effect, EffectInstance(c.effect, c.options, {**small, **angle}), k > 0)
            for k, angle in enumerate(angles)
        ]
    return tuple(found)


def marginal(information: np.ndarray, keep: np.ndarray) -> np.ndarray:
    """Information (k, k) about the kept numbers, with all others free; ``keep`` (m,) is a mask."""
    if keep.all():
        return information
    size = 1.0 / np.sqrt(np.maximum(np.diag(information), 1e-30))
    even = information * np.outer(size, size)
    across = even[np.ix_(~keep, keep)]
    inner = even[np.ix_(~keep, ~keep)] + 1e-9 * np.eye(int(np.sum(~keep)))
    return (even[np.ix_(keep, keep)] - across.T @ np.linalg.solve(inner, across)) / np.outer(size[keep], size[keep])

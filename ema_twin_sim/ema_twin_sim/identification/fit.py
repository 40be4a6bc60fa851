"""Fits: a hypothesis at the values where its misfit is smallest."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, partial

import numpy as np

from ..criteria import CORRELATION
from .equation import EquationErrorProblem, Prediction
from .hypothesis import Hypothesis


@dataclass(frozen=True, eq=False)
class Fit:
    """A hypothesis at its best values: residual and slopes are weighted, ``raw`` is not.

    The slopes are found when they are first asked for: of most fits, only the misfit is.
    """

    hypothesis: Hypothesis
    predicted: Prediction
    raw: np.ndarray  # (m,) measured minus predicted, in units of noise
    weights: np.ndarray  # (m,) square roots of what each row counts
    differentiate: Callable[[], np.ndarray]  # gives the slopes; the same at every call
    misfit: float  # without the priors
    prior_cost: float
    judged: int  # rows that the misfit is over
    variance_inflation: float  # that the priors were held against

    @property
    def temperature(self) -> float:
        """What a difference of misfits is divided by to count in units of the noise: rows are correlated, and what is
        left over makes all of them count less.
        """
        return CORRELATION * max(1.0, self.misfit / self.judged)

    @property
    def jacobian(self) -> np.ndarray:
        """(m, k) weighted slopes of the prediction to the free numbers."""
        return self.differentiate()

    @property
    def residual(self) -> np.ndarray:
        """(m,) residual, outliers weighted down."""
        return self.raw * self.weights

    def slopes(self) -> dict[str, np.ndarray]:
        """By path, how the prediction (m,) changes with each free number."""
        plain = self.jacobian / np.maximum(self.weights, 1e-12)[:, None]
        return {free.path: plain[:, k] for k, free in enumerate(self.hypothesis.free)}

    @property
    def parted(self) -> bool:
        """Whether a gearbox with play or spring is simulated."""
        return bool(self.predicted.plant["two_inertia"][0] != 0.0)


def prior_rows(h: Hypothesis, variance_inflation: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """(residuals, slopes) that the priors add, in units of a noise whose variance is so many times the sensors'."""
    heat = math.sqrt(variance_inflation)
    rows = [(k, f.prior) for k, f in enumerate(h.free) if f.prior is not None]
    r = np.array([heat * (p[0] - h.values[k]) / p[1] for k, p in rows])
    j = np.zeros((len(rows), len(h.free)))
    for row, (k, p) in enumerate(rows):
        j[row, k] = heat / p[1]
    return r, j


class _Beside(EquationErrorProblem):
    """The equation beside a fit whose gearbox is simulated: its numbers act along their slopes, an effect that comes
    or goes adds what it asks for, and nothing is simulated again.
    """

    def __init__(self, equation: EquationErrorProblem, known: Fit) -> None:
        self.__dict__.update(vars(equation))
        self._known = known
        self._slopes = known.slopes()

    @classmethod
    def of(cls, equation: EquationErrorProblem, known: Fit, h: Hypothesis) -> _Beside | None:
        """None where it would not be right: some effect that comes or goes changes how the output moves."""
        if not known.parted or h.base is not known.hypothesis.base:
            return None
        beside = cls(equation, known)
        return beside if beside._changes(h) is not None else None

    def predict(self, h: Hypothesis, beside: Prediction | None = None, *, side_by_side: bool = False) -> Prediction:
        """What the hypothesis predicts, to first order in what it shares with the known fit."""
        known = self._known
        now = h.by_path
        changes = self._changes(h)
        assert changes is not None  # else there is no such equation
        rows = known.predicted.rows + changes
        for path, value in known.hypothesis.by_path.items():
            if path in now or path.startswith("basis."):  # of a generic basis that went, nothing is left
                rows += self._slopes[path] * (now.get(path, 0.0) - value)
        for path, value in now.items():
            if path.startswith("basis.") and path not in self._slopes:
                _, name, place = path.split(".")
                rows += self.generic_bases[name][:, int(place)] * value
        return Prediction(rows, known.predicted.plant, known.predicted.required, known.predicted.by_load)

    def rows_of(self, several: Sequence[Hypothesis]) -> list[np.ndarray]:
        """The rows (m,) that each of several hypotheses predicts."""
        return [self.predict(h).rows for h in several]

    def _changes(self, h: Hypothesis) -> np.ndarray | None:
        """Rows (m,) of the effects that came, less those of the effects that went."""
        there = self._known.hypothesis
        rows = np.zeros(self.rows)
        for name in h.added:
            if name not in there.added:
                more = self.beside(there, self._known.predicted, h.instance(name))
                if more is None:
                    return None
                rows += more
        for name in there.added:
            if name not in h.added:
                less = self.alone(self._known.predicted, there.instance(name))
                if less is None:
                    return None
                rows -= less
        return rows


@np.errstate(over="ignore", invalid="ignore")  # a step too far may blow up; it is not taken then
def fit(
    equation: EquationErrorProblem, h: Hypothesis, iterations: int = 8, tolerance: float = 0.5, known: Fit | None = None
) -> Fit:
    """Levenberg-Marquardt with bounds and priors.

    The slopes of a fit ``known`` are kept for the numbers it shares; and where it simulates a gearbox that stays as it
    is, this is not done again.
    """
    slopes = {}
    if known is not None and known.hypothesis.parted == h.parted:  # else numbers of one name mean other things
        slopes = known.slopes()
        equation = _Beside.of(equation, known, h) or equation
    lower, upper = equation.bounds(h)
    h = h.at(np.clip(h.values, lower, upper))
    predicted = equation.predict(h)
    raw = equation.residual(predicted)
    inflation = equation.weighting.variance_inflation
    pr, pj = prior_rows(h, inflation)
    cost = equation.misfit(raw) + float(pr @ pr)
    damping = 0.0
    weights = equation.weights(raw)
    differentiate = cache(partial(equation.jacobian, h, predicted, weights, slopes))
    for _ in range(iterations):
        jac = differentiate()
        a = jac.T @ jac + pj.T @ pj
        g = jac.T @ (raw * weights) + pj.T @ pr
        # numbers held on a bound that they push against
        held = ((h.values <= lower) & (g < 0)) | ((h.values >= upper) & (g > 0))
        idx = np.flatnonzero(~held)
        if not np.isfinite(a).all():
            break
        scale = np.sqrt(np.maximum(np.diag(a)[idx], 1e-30))
        normal = a[np.ix_(idx, idx)] / np.outer(scale, scale)
        gained = False
        for _try in range(5):
            step = np.zeros(len(h.values))
            step[idx] = np.linalg.solve(normal + (damping + 1e-9) * np.eye(len(idx)), g[idx] / scale) / scale
            if not np.isfinite(step).all():
                break
            trial = h.at(np.clip(h.values + step, lower, upper))
            p = equation.predict(trial, side_by_side=True)
            r = equation.residual(p)
            q, _ = prior_rows(trial, inflation)
            c = equation.misfit(r) + float(q @ q)
            if c < cost:
                gained = True
                break
            damping = max(10.0 * damping, 1e-3)
        if not gained:
            break
        fall = cost - c
        h, predicted, raw, pr, cost = trial, p, r, q, c
        damping = 0.1 * damping if damping > 1e-5 else 0.0
        weights = equation.weights(raw)
        differentiate = cache(partial(equation.jacobian, h, predicted, weights, slopes))
        if fall < tolerance + 1e-5 * cost:
            break
    prior_cost = float(pr @ pr) / inflation
    return Fit(h, predicted, raw, weights, differentiate, equation.misfit(raw), prior_cost, equation.judged, inflation)

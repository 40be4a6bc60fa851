"""Fits: a hypothesis at the values where its misfit is smallest."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache, partial

import numpy as np

from ..parallel import predictions
from .along_slopes import AlongSlopes
from .equation import EquationErrorProblem
from .hypothesis import Hypothesis
from .jacobian import jacobian
from .prediction import Prediction, Predictor

INITIAL_DAMPING = 1e-4
"""Initial damping relative to a squared slope; it keeps nearly equivalent parameters from being thrown far apart."""
NO_GAIN = 0.1
"""A step is not tried if it promises less than this fraction of the decrease that ends a fit."""


@dataclass(frozen=True, eq=False)
class Fit:
    """A hypothesis at its best values. Residual and slopes are weighted, ``raw`` is not.

    It holds the problem that it was fitted to, and with it the weighting: fits compare if their problems do. Slopes are
    computed on first use, since most fits are only asked for their misfit.
    """

    problem: EquationErrorProblem
    hypothesis: Hypothesis
    predicted: Prediction
    raw: np.ndarray  # (m,) measured minus predicted, in units of noise
    weights: np.ndarray  # (m,) square roots of the row weights
    differentiate: Callable[[], np.ndarray]  # returns the slopes; the same at every call
    misfits: tuple[float, float]  # of the torque rows and of the encoder rows, without priors
    prior_cost: float

    @property
    def judged(self) -> tuple[int, int]:
        """Number of torque rows and of encoder rows that the misfits sum over."""
        return self.problem.size, self.problem.judged - self.problem.size

    @property
    def cost(self) -> float:
        """The minimised cost: the misfit, plus the priors scaled by the weighting's variance inflation."""
        return self.misfit + self.problem.weighting.variance_inflation * self.prior_cost

    @property
    def misfit(self) -> float:
        """Misfit of all rows."""
        return sum(self.misfits)

    @property
    def variance_inflations(self) -> tuple[float, float]:
        """Divisors that bring differences of misfit (torque rows, encoder rows) to units of the noise.

        Rows are correlated, and a remaining residual reduces the weight of all rows of its kind. The two kinds are
        separate: interpolation error of an encoder says nothing about how well the torque is known.
        """
        of_torque, of_encoders = (
            self.problem.correlation * max(1.0, misfit / max(count, 1))
            for misfit, count in zip(self.misfits, self.judged, strict=True)
        )
        return of_torque, of_encoders

    @property
    def variance_inflation(self) -> float:
        """Variance inflation for priors, from the noise of the rows that determine the constants.

        These are the torque rows; in a two-inertia model, or without torque data, also the encoder rows.
        """
        if self.judged[0] and not self.parted:
            return self.variance_inflations[0]
        return self.problem.correlation * max(1.0, self.misfit / sum(self.judged))

    @property
    def row_variance_inflations(self) -> np.ndarray:
        """(m,) divisor of each row's squared residual relative to priors."""
        return self.row_variance_inflations_in(self.problem)

    def row_variance_inflations_in(self, problem: EquationErrorProblem) -> np.ndarray:
        """The same (m,) for the rows of other recordings of this machine.

        In a two-inertia model one value for all rows, since both kinds determine the same parameters.
        """
        each = (self.variance_inflation, self.variance_inflation if self.parted else self.variance_inflations[1])
        return np.repeat(each, (problem.size, problem.rows - problem.size))

    @property
    def jacobian(self) -> np.ndarray:
        """(m, k) weighted slopes of the prediction with respect to the free parameters."""
        return self.differentiate()

    @property
    def residual(self) -> np.ndarray:
        """(m,) weighted residual; outliers are down-weighted."""
        return self.raw * self.weights

    def slopes(self) -> dict[str, np.ndarray]:
        """By path: how the prediction (m,) changes with each free parameter."""
        plain = self.jacobian / np.maximum(self.weights, 1e-12)[:, None]
        return {free.path: plain[:, k] for k, free in enumerate(self.hypothesis.free)}

    @property
    def parted(self) -> bool:
        """Whether the model has two inertias (backlash or compliance in the gearbox)."""
        return bool(self.predicted.plant["two_inertia"][0] != 0.0)


def prior_rows(h: Hypothesis, variance_inflation: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """(residuals, slopes) added by the priors, in units of a noise with this multiple of the sensors' variance."""
    root_inflation = math.sqrt(variance_inflation)
    rows = [(k, f.prior) for k, f in enumerate(h.free) if f.prior is not None]
    r = np.array([root_inflation * (p[0] - h.values[k]) / p[1] for k, p in rows])
    j = np.zeros((len(rows), len(h.free)))
    for row, (k, p) in enumerate(rows):
        j[row, k] = root_inflation / p[1]
    return r, j


@np.errstate(over="ignore", invalid="ignore")  # a step that is too long may overflow; it is then rejected
def fit(
    problem: EquationErrorProblem, h: Hypothesis, iterations: int = 8, tolerance: float = 0.5, known: Fit | None = None
) -> Fit:
    """Fit by Levenberg-Marquardt with bounds and priors.

    The slopes of a ``known`` fit are reused for the parameters it shares. If its two-inertia output motion stays the
    same, the output is not simulated again.
    """
    slopes: dict[str, np.ndarray] = {}
    predictor: Predictor = problem
    if known is not None and known.hypothesis.parted == h.parted:  # otherwise equal names have different meanings
        slopes = known.slopes()
        along = AlongSlopes(problem, known.hypothesis, known.predicted, slopes)
        if known.parted and along.holds_for(h):
            predictor = along
    lower, upper = problem.bounds(h)
    h = h.at(np.clip(h.values, lower, upper))
    predicted = predictor.predict(h)
    raw = problem.residual(predicted)
    inflation = problem.weighting.variance_inflation
    pr, pj = prior_rows(h, inflation)
    cost = problem.misfit(raw) + float(pr @ pr)
    damping = INITIAL_DAMPING
    weights = problem.weights(raw)
    differentiate = cache(partial(jacobian, problem, h, predicted, weights, slopes, predictor))
    for _ in range(iterations):
        jac = differentiate()
        a = jac.T @ jac + pj.T @ pj
        g = jac.T @ (raw * weights) + pj.T @ pr
        # parameters held at a bound that they push against
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
            whole = np.array_equal(trial.values, h.values + step)  # otherwise a smaller step may gain
            if whole and float(step @ (2.0 * g - a @ step)) < NO_GAIN * tolerance:
                break
            p = predictor.predict(trial, side_by_side=True)
            r = problem.residual(p)
            q, _ = prior_rows(trial, inflation)
            c = problem.misfit(r) + float(q @ q)
            if c < cost:
                gained = True
                break
            damping = max(10.0 * damping, 1e-3)
        if not gained:
            break
        fall = cost - c
        h, predicted, raw, pr, cost = trial, p, r, q, c
        damping = 0.1 * damping if damping > 1e-5 else 0.0
        weights = problem.weights(raw)
        differentiate = cache(partial(jacobian, problem, h, predicted, weights, slopes, predictor))
        if fall < tolerance + 1e-5 * cost:
            break
    prior_cost = float(pr @ pr) / inflation
    costs = problem.costs(raw)
    misfits = float(costs[: problem.size].sum()), float(costs[problem.size :].sum())
    return Fit(problem, h, predicted, raw, weights, differentiate, misfits, prior_cost)


def fits(
    problem: EquationErrorProblem, several: Iterable[Hypothesis], iterations: int = 8, known: Fit | None = None
) -> list[Fit]:
    """Fits of several hypotheses in parallel; everything else as in ``fit``."""
    if known is not None:
        known.differentiate()  # once for all of them
    return list(predictions(problem.samples, lambda h: fit(problem, h, iterations, known=known), several))

"""Fits: a hypothesis at the values where its misfit is smallest."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache, partial

import numpy as np

from ..criteria import CORRELATION
from ..parallel import predictions
from .along_slopes import AlongSlopes
from .equation import EquationErrorProblem
from .hypothesis import Hypothesis
from .jacobian import jacobian
from .prediction import Prediction, Predictor

INITIAL_DAMPING = 1e-4
"""Of a slope's square, at which a fit begins: numbers that hardly differ in what they do are not thrown far apart."""
NO_GAIN = 0.1
"""Times the fall that ends a fit: a step that promises less is not tried."""


@dataclass(frozen=True, eq=False)
class Fit:
    """A hypothesis at its best values: residual and slopes are weighted, ``raw`` is not.

    It holds the problem that it was fitted to, and with it the weighting: fits compare where their problems do. The
    slopes are found when they are first asked for: of most fits, only the misfit is.
    """

    problem: EquationErrorProblem
    hypothesis: Hypothesis
    predicted: Prediction
    raw: np.ndarray  # (m,) measured minus predicted, in units of noise
    weights: np.ndarray  # (m,) square roots of what each row counts
    differentiate: Callable[[], np.ndarray]  # gives the slopes; the same at every call
    misfits: tuple[float, float]  # of the torque's rows and of the encoders', without the priors
    prior_cost: float

    @property
    def judged(self) -> tuple[int, int]:
        """How many rows of the torque, and of the encoders, the misfits are over."""
        return self.problem.size, self.problem.judged - self.problem.size

    @property
    def cost(self) -> float:
        """What was made small: the misfit, and the priors held against the noise as the weighting has it."""
        return self.misfit + self.problem.weighting.variance_inflation * self.prior_cost

    @property
    def misfit(self) -> float:
        """Of all rows."""
        return sum(self.misfits)

    @property
    def variance_inflations(self) -> tuple[float, float]:
        """What a difference of misfits, of the torque's rows and of the encoders', is divided by to count in units of
        the noise: rows are correlated, and what is left over makes all rows of its kind count less.

        What an encoder errs by between its lines says nothing of how well the torque is known.
        """
        of_torque, of_encoders = (
            CORRELATION * max(1.0, misfit / max(count, 1))
            for misfit, count in zip(self.misfits, self.judged, strict=True)
        )
        return of_torque, of_encoders

    @property
    def variance_inflation(self) -> float:
        """What priors are held against: the noise of the rows that tell of the constants.

        Those of the torque; where the output parts from the motor, or no torque was measured, the encoders' as well.
        """
        if self.judged[0] and not self.parted:
            return self.variance_inflations[0]
        return CORRELATION * max(1.0, self.misfit / sum(self.judged))

    @property
    def row_variance_inflations(self) -> np.ndarray:
        """(m,) what each row's squared residual is divided by beside priors."""
        return self.row_variance_inflations_in(self.problem)

    def row_variance_inflations_in(self, problem: EquationErrorProblem) -> np.ndarray:
        """The same (m,) for the rows of other recordings of this machine.

        One for all where the output parts from the motor, since rows of both kinds tell of the same numbers there.
        """
        each = (self.variance_inflation, self.variance_inflation if self.parted else self.variance_inflations[1])
        return np.repeat(each, (problem.size, problem.rows - problem.size))

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
    root_inflation = math.sqrt(variance_inflation)
    rows = [(k, f.prior) for k, f in enumerate(h.free) if f.prior is not None]
    r = np.array([root_inflation * (p[0] - h.values[k]) / p[1] for k, p in rows])
    j = np.zeros((len(rows), len(h.free)))
    for row, (k, p) in enumerate(rows):
        j[row, k] = root_inflation / p[1]
    return r, j


@np.errstate(over="ignore", invalid="ignore")  # a step too far may blow up; it is not taken then
def fit(
    problem: EquationErrorProblem, h: Hypothesis, iterations: int = 8, tolerance: float = 0.5, known: Fit | None = None
) -> Fit:
    """Levenberg-Marquardt with bounds and priors.

    The slopes of a fit ``known`` are kept for the numbers it shares; and where it simulates a gearbox that stays as it
    is, this is not done again.
    """
    slopes: dict[str, np.ndarray] = {}
    predictor: Predictor = problem
    if known is not None and known.hypothesis.parted == h.parted:  # else numbers of one name mean other things
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
            whole = np.array_equal(trial.values, h.values + step)  # else a smaller step may gain what this one loses
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
    """Fits of several hypotheses, side by side; all else as ``fit`` has it."""
    if known is not None:
        known.differentiate()  # once, for all of them
    return list(predictions(problem.samples, lambda h: fit(problem, h, iterations, known=known), several))

"""Screening: what each effect of the catalogue would gain, by one linear regression beside a fit."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..effects import Effect, catalogue
from ..model import EffectInstance
from .candidates import Candidate, starts
from .equation import EquationErrorProblem
from .fit import Fit, prior_rows
from .parallel import predictions
from .search_limits import Reached
from .start_values import regressed_angle

STEP = 1e-2  # of a typical size: at which an effect is taken to grow in proportion


@dataclass(frozen=True, eq=False)
class Screened:
    """A candidate's gain, in units of the noise, by linear regression, and the parameters it begins with."""

    candidate: Candidate
    start: dict[str, float]
    gain: float
    give_way: Callable[[], np.ndarray]  # by how much (k,) the numbers that were free before do, once it is asked for


@dataclass(frozen=True, eq=False)
class _Known:
    """What a fit's free numbers can do, priors included: an orthonormal basis of it, and what is left over."""

    basis: np.ndarray  # (m, k)
    upper: np.ndarray  # (k, k), times the basis: the slopes
    left: np.ndarray  # (m,)
    root_inflation: np.ndarray  # (m,) what each row is divided by to count as much as a prior does

    @classmethod
    def of(cls, f: Fit) -> _Known:
        pr, pj = prior_rows(f.hypothesis)
        root_inflation = np.sqrt(f.row_variance_inflations)
        slopes = np.concatenate([f.jacobian / root_inflation[:, None], pj])
        size = np.maximum(np.linalg.norm(slopes, axis=0), 1e-30)
        basis, upper = np.linalg.qr(slopes / size)
        residual = np.concatenate([f.residual / root_inflation, pr])
        return cls(basis, upper * size, residual - basis @ (basis.T @ residual), root_inflation)

    def shift(self, rows: np.ndarray) -> Callable[[], np.ndarray]:
        """By how much (k,) the free numbers give way where ``rows`` (m,) more are predicted."""
        within = self.basis.T @ rows
        return lambda: -np.linalg.lstsq(self.upper, within, rcond=1e-9)[0]


def screen(problem: EquationErrorProblem, f: Fit, options: Sequence[Candidate]) -> list[Screened]:
    """Each candidate's gain before its price, at its best start, best first."""
    known = _Known.of(f)
    jobs = [(c, group) for c in options for group in _start_groups(catalogue()[c.effect], problem.reached)]
    found: dict[str, Screened] = {}
    for c, screened in predictions(problem.samples, lambda job: (job[0], _screened(problem, f, known, *job)), jobs):
        if screened is not None and (c.name not in found or screened.gain > found[c.name].gain):
            found[c.name] = screened
    for c in options:
        if c.effect == "torque_constant_error":
            screened = _one_factor(f, c)
            if c.name not in found or screened.gain > found[c.name].gain:
                found[c.name] = screened
    return sorted(found.values(), key=lambda s: -s.gain)


def _one_factor(f: Fit, c: Candidate) -> Screened:
    """What a torque constant gains that only puts constants back: all torques are off by one factor.

    No simulation would tell, and a straight line leads away from it beside a gearbox.
    """
    h = f.hypothesis
    size = catalogue()[c.effect].parameters[0]
    scale = min(max(h.factor_to_file(), size.lower), size.upper)
    moved = h.with_torques_times(scale)
    pr, _ = prior_rows(moved)
    return Screened(c, {size.name: scale}, f.prior_cost - float(pr @ pr), lambda: moved.values - h.values)


def _start_groups(effect: Effect, of: Reached) -> list[list[dict[str, float]]]:
    """Starts that differ in one angle only stand together: a wave of any angle is a sum of theirs."""
    angle = regressed_angle(effect)
    turning = None if angle is None else angle.name
    groups: dict[tuple[float, ...], list[dict[str, float]]] = {}
    for s in starts(effect, of):
        groups.setdefault(tuple(v for k, v in s.items() if k != turning), []).append(s)
    return list(groups.values())


def _screened(
    problem: EquationErrorProblem, f: Fit, known: _Known, c: Candidate, group: Sequence[dict[str, float]]
) -> Screened | None:
    """What a candidate gains at one start, its angle free; None where it changes nothing, or is no number."""
    effect = catalogue()[c.effect]
    size = effect.parameters[0]
    per = 1.0 if size.neutral is None else STEP * max(abs(size.default - size.neutral), 1e-9)

    columns = _columns(problem, f, known, c, group, per)
    if not np.isfinite(columns).all():
        return None
    inside = known.basis.T @ columns
    square = columns.T @ columns - inside.T @ inside  # of what the free numbers cannot do
    along = columns.T @ known.left
    start = dict(group[0])
    if size.neutral is None:
        whole, norm = float(2.0 * along[0] - square[0, 0]), float(square[0, 0])
        # a share of it may fit better than all of it
        share = 0.5 * float(along[0]) ** 2 / norm if along[0] > 0.0 and norm > 0.0 else -math.inf
        return Screened(c, start, max(whole, share), lambda: np.zeros(len(known.upper)))
    if math.sqrt(max(np.diag(square).max(), 0.0)) < 1e-9:
        return None
    x = np.linalg.lstsq(square, along, rcond=1e-9)[0]
    turning = regressed_angle(effect)
    if turning is not None:
        start[turning.name] = math.atan2(x[1], x[0])
        value = size.neutral + math.hypot(*x)
    else:
        value = size.neutral + float(x[0])
    clipped = min(max(value, size.lower), size.upper)
    start[size.name] = clipped
    taken = x * ((clipped - size.neutral) / (value - size.neutral) if clipped != value else 1.0)
    gained = float(2.0 * taken @ along - taken @ square @ taken)
    return Screened(c, start, gained, known.shift(columns @ taken))


def _columns(
    problem: EquationErrorProblem,
    f: Fit,
    known: _Known,
    c: Candidate,
    group: Sequence[dict[str, float]],
    per: float,
) -> np.ndarray:
    """Rows (m, k) that a candidate adds to a fit at each start, per unit of its size; it is ``per`` beyond neutral."""
    size = catalogue()[c.effect].parameters[0]

    def column(parameters: dict[str, float]) -> np.ndarray:
        if size.neutral is not None:
            parameters = {**parameters, size.name: size.neutral + per}
        instance = EffectInstance(c.effect, c.options, parameters)
        rows = None
        if size.neutral is not None:
            rows = problem.beside(f.hypothesis, f.predicted, instance, again=True)
        if rows is None:
            h = f.hypothesis.with_effect(c.effect, c.options, parameters)
            rows = problem.centred(problem.predict(h).rows - f.predicted.rows, f.weights)
        return np.concatenate([rows * f.weights / (per * known.root_inflation), np.zeros(len(known.left) - len(f.raw))])

    return np.stack([column(s) for s in group], 1)


def screen_generic_bases(problem: EquationErrorProblem, f: Fit) -> list[tuple[float, str]]:
    """(gain, less two a column for chance; name) of each generic basis by linear regression, best first."""
    known = _Known.of(f)
    q, r = known.basis, known.left
    found = []
    for name, columns in problem.generic_bases.items():
        if name in f.hypothesis.generic_bases:
            continue
        a = np.concatenate(
            [columns * (f.weights / known.root_inflation)[:, None], np.zeros((len(r) - len(f.raw), columns.shape[1]))]
        )
        a -= q @ (q.T @ a)
        u, s, _ = np.linalg.svd(a, full_matrices=False)
        u = u[:, s > 1e-6 * max(s[0], 1e-12)]
        found.append((float(np.sum((u.T @ r) ** 2)) - 2.0 * u.shape[1], name))
    return sorted(found, reverse=True)

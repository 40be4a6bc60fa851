"""Screening: the gain of each effect of the catalogue, by one linear regression on the residual of a fit."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..effects import Effect, catalogue
from ..model import EffectInstance
from ..model.own_units import table_in
from ..model.roles import TORQUE_FACTOR
from ..parallel import predictions
from .candidates import Candidate, starts
from .equation import EquationErrorProblem, torque_scale
from .fit import Fit, prior_rows
from .start_values import regressed_angle
from .wandering import HARDLY

STEP = 1e-2  # of a typical size; within it an effect is taken as linear
AT_ONCE = 20_000_000  # bytes at most of rows that are processed together


@dataclass(frozen=True, eq=False)
class Screened:
    """A candidate's gain by linear regression, in units of the noise, and its start parameters."""

    candidate: Candidate
    start: dict[str, float]
    gain: float
    give_way: Callable[[], np.ndarray]  # computes the change (k,) of the earlier free parameters


@dataclass(frozen=True, eq=False)
class Known:
    """What a fit's free parameters can explain, priors included: an orthonormal basis, and the residual outside it."""

    basis: np.ndarray  # (m, k)
    upper: np.ndarray  # (k, k), basis @ upper gives the slopes
    left: np.ndarray  # (m,)
    root_inflation: np.ndarray  # (m,) divisor that gives each row the weight of a prior

    @classmethod
    def of(cls, f: Fit) -> Known:
        """What a fit explains, and leaves."""
        pr, pj = prior_rows(f.hypothesis)
        root_inflation = np.sqrt(f.row_variance_inflations)
        slopes = np.concatenate([f.jacobian / root_inflation[:, None], pj])
        size = np.maximum(np.linalg.norm(slopes, axis=0), 1e-30)
        basis, upper = np.linalg.qr(slopes / size)
        residual = np.concatenate([f.residual / root_inflation, pr])
        return cls(basis, upper * size, residual - basis @ (basis.T @ residual), root_inflation)

    def shift(self, within: np.ndarray) -> Callable[[], np.ndarray]:
        """Change (k,) of the free parameters that compensates rows with components ``within`` (k,) in their span."""
        return lambda: -np.linalg.lstsq(self.upper, within, rcond=1e-9)[0]


def screen(problem: EquationErrorProblem, f: Fit, options: Sequence[Candidate]) -> list[Screened]:
    """Each candidate's gain before its penalty, at its best start, best first."""
    known = Known.of(f)
    together = max(1, AT_ONCE // max(problem.rows * problem.in_noise.itemsize, 1))
    jobs = [
        (c, groups[k : k + together])
        for c in options
        for groups in [_start_groups(problem, f, c)]
        for k in range(0, len(groups), together)
    ]
    found: dict[str, Screened] = {}
    for several in predictions(problem.samples, lambda job: _screened(problem, f, known, *job), jobs):
        for screened in several:
            name = screened.candidate.name
            if name not in found or screened.gain > found[name].gain:
                found[name] = screened
    for c in options:
        if c.effect == TORQUE_FACTOR:
            screened = _one_factor(f, c)
            if c.name not in found or screened.gain > found[c.name].gain:
                found[c.name] = screened
    return sorted(found.values(), key=lambda s: -s.gain)


def _one_factor(f: Fit, c: Candidate) -> Screened:
    """Gain of a torque constant that only moves constants back to the file: all torques are off by one factor.

    A simulation would not show it, and with a gearbox a linearisation leads away from it.
    """
    h = f.hypothesis
    size = catalogue()[c.effect].parameters[0]
    scale = min(max(h.factor_to_file(), size.lower), size.upper)
    moved = h.with_torques_times(scale)
    pr, _ = prior_rows(moved)
    return Screened(c, {size.name: scale}, f.prior_cost - float(pr @ pr), lambda: moved.values - h.values)


def _start_groups(problem: EquationErrorProblem, f: Fit, c: Candidate) -> list[list[dict[str, float]]]:
    """Group starts that differ only in one angle: a wave of any phase is a sum of theirs."""
    angle = regressed_angle(_effect(f, c))
    turning = None if angle is None else angle.name
    groups: dict[tuple[float, ...], list[dict[str, float]]] = {}
    for s in starts(c, problem.reached, f.hypothesis.base.units):
        groups.setdefault(tuple(v for k, v in s.items() if k != turning), []).append(s)
    return list(groups.values())


def _effect(f: Fit, c: Candidate) -> Effect:
    """The effect of a candidate, the numbers of its table in the units of a fit's model."""
    return table_in(catalogue()[c.effect], f.hypothesis.base.units)


def _screened(
    problem: EquationErrorProblem, f: Fit, known: Known, c: Candidate, groups: Sequence[Sequence[dict[str, float]]]
) -> list[Screened]:
    """Gain of a candidate at each of its starts, with its angle free; starts that change nothing are left out."""
    effect = _effect(f, c)
    size = effect.parameters[0]
    per = 1.0 if size.neutral is None else STEP * max(abs(size.default - size.neutral), 1e-9)
    plain, scale = _columns(problem, f, c, [start for group in groups for start in group], per)
    rows = len(plain)  # torque rows only, or all
    columns = plain * (f.weights[:rows] / (scale * known.root_inflation[:rows]))[:, None]
    inside = known.basis[:rows].T @ columns
    along = columns.T @ known.left[:rows]
    found = []
    stop = 0
    for group in groups:
        part = slice(stop, stop := stop + len(group))
        # the part outside the span of the free parameters
        square = columns[:, part].T @ columns[:, part] - inside[:, part].T @ inside[:, part]
        if np.isfinite(square).all():
            screened = _at_start(c, effect, group, inside[:, part], square, along[part], known)
            found += [] if screened is None else [screened]
    return found


def _at_start(
    c: Candidate,
    effect: Effect,
    group: Sequence[dict[str, float]],
    inside: np.ndarray,
    square: np.ndarray,
    along: np.ndarray,
    known: Known,
) -> Screened | None:
    """Gain of a candidate at one start, from products of its columns with each other and with the residual."""
    size = effect.parameters[0]
    start = dict(group[0])
    if size.neutral is None:
        whole, norm = float(2.0 * along[0] - square[0, 0]), float(square[0, 0])
        # a fraction of it may fit better than all of it
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
    return Screened(c, start, gained, known.shift(inside @ taken))


def _columns(
    problem: EquationErrorProblem, f: Fit, c: Candidate, starts: Sequence[dict[str, float]], per: float
) -> tuple[np.ndarray, float]:
    """Rows (m, k) that a candidate adds to a fit at each start, or torque rows only (s, k) if these are all.

    Its size is ``per`` beyond neutral. The second value is the divisor that gives the rows per unit of its size.
    """
    size = _effect(f, c).parameters[0]
    if size.neutral is not None:
        starts = [{**start, size.name: size.neutral + per} for start in starts]
        every = problem.alike_beside_any(f.predicted, [EffectInstance(c.effect, c.options, one) for one in starts])
        if every is not None:
            return every, per * torque_scale(f.predicted.plant[0])

    def column(parameters: dict[str, float]) -> np.ndarray:
        rows = None
        if size.neutral is not None:
            rows = problem.beside(f.hypothesis, f.predicted, EffectInstance(c.effect, c.options, parameters))
        if rows is None:
            h = f.hypothesis.with_effect(c.effect, c.options, parameters)
            rows = problem.centred(problem.predict(h).rows - f.predicted.rows, f.weights)
        return rows

    return np.stack([column(start) for start in starts], 1), per


def span_of(f: Fit, columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Orthonormal basis (m + p, k) of what columns (m, c) add to a fit's free parameters and their p priors.

    The second value (m,) divides the residual's rows, so that they weigh as much as a prior.
    """
    known = Known.of(f)
    outside = _outside(f, known, columns)
    squares, axes = np.linalg.eigh(outside.T @ outside)
    kept = squares > HARDLY * max(squares[-1], 1e-24)
    return outside @ axes[:, kept] / np.sqrt(squares[kept]), known.root_inflation


def _outside(f: Fit, known: Known, columns: np.ndarray) -> np.ndarray:
    """Columns (m, c) as weighted in a fit, one row a prior below them, outside the span of its free parameters."""
    below = np.zeros((len(known.left) - len(f.raw), columns.shape[1]))
    a = np.concatenate([columns * (f.weights / known.root_inflation)[:, None], below])
    return a - known.basis @ (known.basis.T @ a)


def screen_generic_bases(problem: EquationErrorProblem, f: Fit) -> list[tuple[float, str]]:
    """(gain minus two a column for chance, name) of each generic basis by linear regression, best first."""
    known = Known.of(f)
    r = known.left
    found = []
    for name, columns in problem.generic_bases.items():
        if name in f.hypothesis.generic_bases:
            continue
        a = _outside(f, known, columns)
        squares, axes = np.linalg.eigh(a.T @ a)
        along = axes.T @ (a.T @ r)
        kept = squares > HARDLY * max(squares[-1], 1e-24)
        found.append((float(np.sum(along[kept] ** 2 / squares[kept])) - 2.0 * int(kept.sum()), name))
    return sorted(found, reverse=True)

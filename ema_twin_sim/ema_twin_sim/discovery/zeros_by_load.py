"""Zeros of positions that differ between recordings, by a load that depends on where the output stands.

An incremental counter reads zero wherever it is switched on. The same arm or return spring then acts at another angle
in each recording, and no common one explains it; a shift of each recording does, with one size for all of them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..criteria import MOSTLY, NEGLIGIBLE
from ..effects import Trait, catalogue, effects_with
from ..identification.fit import Fit
from ..identification.loads_at_an_angle import Load, loads_at_an_angle, loads_of
from ..identification.screening import Known
from ..model import EffectInstance, Model
from ..plant.motion import MOTOR_ANGLE

SAME_ROWS = 1e-9  # relative: columns that explain the same but for rounding
Products = tuple[np.ndarray, np.ndarray]
"""Of columns (m, k) with each other (k, k), and with the residual (k,)."""


def zeros_by_load(f: Fit) -> dict[str, float]:
    """Angle [rad] to add to the motor's position, by recording, for a model that lacks a load; none if unsure.

    The first recording keeps its zero. All must begin where their counters read zero. An arm at one zero and a constant
    load, another in each recording, must not explain as much as an arm does, nor more than a spring. (Beside a spring
    such a constant load is the same as another zero.)
    """
    if len(f.problem.observations) < 2 or loads_of(f.hypothesis.base) or not _may_tell(f):
        return {}
    columns = _Columns(f)
    loads, steady = loads_at_an_angle(f.hypothesis.base), _steady_loads()
    every = [*steady, *(one for load in loads for one in load.two)]
    arms = [one for load in loads if load.angle.periodic for one in load.two]
    at_one_zero = min(columns.left(together=every), columns.left(apart=steady))
    arm_and_weights = columns.left(apart=steady, together=arms)
    best, left = {}, math.inf
    for load in loads:
        after, angles = columns.at_free_angles(load)
        rival = (1.0 - MOSTLY if load.angle.periodic else 1.0) * arm_and_weights
        if after < min(left, (1.0 - MOSTLY) * at_one_zero, rival):
            left, best = after, _at_the_motor(f, load.moved(angles, angles[0]))
    return best


def zeros_by_known_load(f: Fit, model: Model) -> dict[str, float]:
    """The same for a ``model`` with one such load, where its own angle is; ``f`` is the fit without it."""
    held = [model.effects[name] for name in loads_of(model)]
    loads = [load for load in loads_at_an_angle(model) if held and load.is_of(held[0])]
    if len(held) != 1 or not loads or not _may_tell(f):
        return {}
    (load,), (instance,) = loads, held
    size = load.effect.parameters[0]
    angle = instance.parameters[load.angle.name]
    columns = _Columns(f)
    known = instance.parameters[size.name] / size.default
    told = np.full(len(f.problem.observations), angle)
    steady = _steady_loads() if load.angle.periodic else []
    after, angles = columns.at_free_angles(load, known)
    if after >= (1.0 - MOSTLY) * columns.left_at(load, known, told, beside=steady):
        return {}
    return _at_the_motor(f, load.moved(angles, angle))


def _steady_loads() -> list[EffectInstance]:
    """The loads that are the same wherever the output stands."""
    effects = (catalogue()[id] for id in sorted(effects_with(Trait.LOAD)))
    return [
        EffectInstance(effect.id, effect.default_options(), effect.default_parameters())
        for effect in effects
        if effect.depends_on != "output_position"
    ]


def _may_tell(f: Fit) -> bool:
    """Whether all counters read zero where their recordings begin, and nothing but they tells where the output is.

    On a rigid drivetrain whose friction does not follow its load: there a load only adds its torque.
    """
    problem = f.problem
    begin_at_zero = problem.rows == problem.size > 0 and all(
        not o.of_points
        and abs(o.motor_origin + o.motion[0, MOTOR_ANGLE]) <= NEGLIGIBLE * float(np.ptp(o.motion[:, MOTOR_ANGLE]))
        for o in problem.observations
    )
    return begin_at_zero and all(problem.alone(f.predicted, one) is not None for one in _steady_loads())


def _at_the_motor(f: Fit, ways: np.ndarray) -> dict[str, float]:
    """Ways (R,) [rad] of the output as those of the motor, by recording; those of hardly any are left out."""
    ratio = f.hypothesis.base.value("machine.gear_ratio")
    least = NEGLIGIBLE * float(np.max(np.abs(ways)))
    return {o.name: ratio * float(way) for o, way in zip(f.problem.observations, ways, strict=True) if abs(way) > least}


class _Columns:
    """Products of the rows that loads add to a fit, beside its free parameters: one set for all, or one a recording."""

    def __init__(self, f: Fit) -> None:
        self._f, self._known = f, Known.of(f)
        self._all = float(self._known.left @ self._known.left)

    def _products(self, apart: Sequence[EffectInstance], together: Sequence[EffectInstance] = ()) -> Products:
        """For the loads ``apart``, of a size of their own in each recording, and those of one size ``together``."""
        from scipy.linalg import block_diag  # half a second, and most recordings do not come so far

        known, size, parts = self._known, self._f.problem.size, self._f.problem.torque_parts
        own, common = self._rows(apart), self._rows(together)
        left, basis = known.left[:size], known.basis[:size]
        square = np.block(
            [
                [
                    block_diag(*(own[p].T @ own[p] for p in parts)),
                    np.concatenate([own[p].T @ common[p] for p in parts]),
                ],
                [np.concatenate([common[p].T @ own[p] for p in parts], axis=1), common.T @ common],
            ]
        )
        inside = np.concatenate([*(basis[p].T @ own[p] for p in parts), basis.T @ common], axis=1)
        along = np.concatenate([*(own[p].T @ left[p] for p in parts), common.T @ left])
        return square - inside.T @ inside, along

    def _rows(self, loads: Sequence[EffectInstance]) -> np.ndarray:
        """Torque rows (m, k) that loads add to the fit, as they are weighted."""
        problem, known, size = self._f.problem, self._known, self._f.problem.size
        rows = np.zeros((size, len(loads)))
        for k, load in enumerate(loads):
            alone = problem.alone(self._f.predicted, load)
            assert alone is not None  # see ``_may_tell``
            rows[:, k] = alone[:size]
        return rows * (self._f.weights[:size] / known.root_inflation[:size])[:, None]

    def left(self, *, apart: Sequence[EffectInstance] = (), together: Sequence[EffectInstance] = ()) -> float:
        """What loads of any size leave of the squares of the residual, in units of noise."""
        square, along = self._products(apart, together)
        return self._all - _explained(square, along)

    def left_at(self, load: Load, size: float, angles: np.ndarray, beside: Sequence[EffectInstance] = ()) -> float:
        """The same for a load of a ``size`` (in usual ones) at an angle (R,) [rad] of each recording.

        ``beside`` are loads of any size, another in each recording.
        """
        square, along = self._products([*load.two, *beside])
        per = 2 + len(beside)
        held = np.arange(len(along)) % per < 2
        shares = load.shares(size, angles).ravel()
        gained = float(2.0 * shares @ along[held] - shares @ square[np.ix_(held, held)] @ shares)
        rest = along[~held] - square[np.ix_(~held, held)] @ shares
        return self._all - gained - _explained(square[np.ix_(~held, ~held)], rest)

    def at_free_angles(self, load: Load, size: float | None = None) -> tuple[float, np.ndarray]:
        """What a load leaves that has one size, but an angle of its own in each recording; and these (R,) [rad].

        ``size`` is in usual ones, None if it is free.
        """
        from scipy.optimize import least_squares  # as long

        square, along = self._products(load.two)
        values, axes = np.linalg.eigh(square)
        kept = values > SAME_ROWS * values[-1]
        root = np.sqrt(values[kept])[:, None] * axes[:, kept].T
        goal = (axes[:, kept].T @ along) / np.sqrt(values[kept])
        sizes, angles = load.of_shares(np.linalg.lstsq(square, along, rcond=SAME_ROWS)[0].reshape(-1, 2))
        held = size is not None
        started = size if size is not None else float(np.median(sizes))

        def missed(x: np.ndarray) -> np.ndarray:
            return root @ load.shares(started if held else x[0], x[1:]).ravel() - goal

        found = least_squares(missed, [started, *angles], x_scale="jac").x
        if not found[0] > 0.0:
            return math.inf, angles
        return self.left_at(load, started if held else float(found[0]), found[1:]), found[1:]


def _explained(square: np.ndarray, along: np.ndarray) -> float:
    """What the best sizes of columns explain, given their products (k, k) with each other and (k,) with the rest."""
    return float(along @ np.linalg.lstsq(square, along, rcond=SAME_ROWS)[0]) if len(along) else 0.0

"""Stops: dry friction while a machine sticks at a reversal, which is not a function of speed.

A machine that reverses comes to rest and sticks until its drive pushes harder than the friction holds. During that time
friction equals the drive torque: below the level of either direction and, on average, in the direction of the drive
torque, which is that of the acceleration. In a model by speed that torque looks like inertia. Its size in a recording
is one number that is of no interest. So its direction is projected out of all measured and predicted rows, and the rows
keep their weight.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..criteria import STANDSTILL
from ..measured.observation import Observation
from ..measured.smoothing import smooth_at
from ..plant.motion import ACCELERATION, SPEED


@dataclass(frozen=True, eq=False)
class Stops:
    """For each recording with stops: its torque rows and the unit vector (s,) along which they may be off."""

    parts: tuple[tuple[slice, np.ndarray], ...]

    @classmethod
    def of(cls, observations: Sequence[Observation], torque_parts: Sequence[slice]) -> Stops:
        """The stops of recordings, if dry friction can explain them.

        With a gearbox that can separate, rows close to a reversal are not judged. Friction at rest acts with the drive
        and is at most its sliding level; residuals at reversals outside that range have another cause.
        """
        judged = [
            (part, _by_friction(o))
            for o, part in zip(observations, torque_parts, strict=True)
            if not o.geared and not o.of_points and len(o.rows)
        ]
        columns = [(part, column) for part, column in judged if column.any()]
        if not columns:
            return cls(())
        shares = _shares(observations, columns)
        return cls(
            tuple(
                (part, column / np.linalg.norm(column))
                for (part, column), share in zip(columns, shares, strict=True)
                if 0.0 < share < 1.0
            )
        )

    def taken_out(self, rows: np.ndarray) -> np.ndarray:
        """Rows (m,) or columns of rows (m, k), in units of the sensors' noise, without the part along stops."""
        if not self.parts:
            return rows
        out = rows.copy()
        for part, direction in self.parts:
            along = direction @ rows[part]
            out[part] -= direction * along if rows.ndim == 1 else np.outer(direction, along)
        return out


def _by_friction(o: Observation) -> np.ndarray:
    """Rows (s,) of a unit torque that acts along the acceleration while the machine may stick."""
    speed = o.motion[:, SPEED]
    stuck = np.abs(speed) < STANDSTILL
    passing = np.flatnonzero(speed[1:] * speed[:-1] <= 0.0)
    stuck[passing] = stuck[passing + 1] = True
    return _at_rows(o, stuck * np.sign(o.motion[:, ACCELERATION]))


def _at_rows(o: Observation, torque: np.ndarray) -> np.ndarray:
    """A torque (n,) at a recording's rows (s,), in units of their noise."""
    rows = np.zeros(len(o.rows))
    smooth_at(np.ascontiguousarray(torque), o.kernel, o.rows, rows)
    return rows / o.torque_noise


def _shares(observations: Sequence[Observation], columns: Sequence[tuple[slice, np.ndarray]]) -> np.ndarray:
    """Torque of each column as a share of the dry friction level.

    It is regressed together with inertia, sliding friction and a constant load.
    """
    each = []
    for o in observations:
        speed = o.motion[:, SPEED]
        sliding = _at_rows(o, np.sign(speed)), _at_rows(o, speed)
        each.append(np.stack([*sliding, o.acceleration / o.torque_noise, 1.0 / o.torque_noise], axis=1))
    rows = np.concatenate(each)
    of_stops = np.zeros((len(rows), len(columns)))
    for k, (part, column) in enumerate(columns):
        of_stops[part, k] = column
    torque = np.concatenate([o.torque / o.torque_noise for o in observations])
    every = np.concatenate([rows, of_stops], axis=1)
    size = np.maximum(np.linalg.norm(every, axis=0), np.finfo(float).tiny)
    found = np.linalg.lstsq(every / size, torque, rcond=None)[0] / size
    level, stuck = found[0], found[rows.shape[1] :]
    return stuck / level if level > 0.0 else np.zeros(len(stuck))

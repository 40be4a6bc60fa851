"""The sign of a drive's current or torque by friction alone: over places passed both ways, beside a load that stays.

A hoist's load may be ten times its friction, so that friction and inertia are no real share of the torque. But where
the machine comes back over the same way, the drive gave more torque forwards than backwards, by twice the friction.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from ema_bench_replay.recording import Recording

from ..criteria import CORRELATION, DEPENDS, PART, SMALL
from ..model import Model
from ..plant.motion import LOAD, MOTOR_ANGLE, SPEED
from .drive_regression import agreed_sign, brings_energy, least_beside, pieces_in_motion
from .observation import Observation
from .robust_regression import robust_regression
from .way_by_speed import FEWEST


def sign_by_friction(recording: Recording, model: Model) -> int:
    """The sign of a recording's current or torque: 1 if friction opposes it as read, -1 if reversed, 0 if undecided.

    It is undecided without a motion both ways over the same places. Recording and model are in the machine's own units.
    """
    return 0 if recording.of_points else agreed_sign(_signs(recording, model))


def _signs(recording: Recording, model: Model) -> Iterator[int]:
    """The same of each piece of the recording that shows a motion.

    Loads of any sign may depend on the place, and may drift. Rows far off all that, as of a rope that is slack at
    first, count less. One sign must explain much more than the other, and more than chance.
    """
    ratio = model.value("machine.gear_ratio")
    for _, seen in pieces_in_motion(recording, model):
        rows = _passed_both_ways(seen)
        if rows is None:
            continue
        speed, place = (seen.motion[seen.rows, column][rows] for column in (SPEED, MOTOR_ANGLE))
        drift = np.linspace(-1.0, 1.0, len(seen.motion))[seen.rows][rows]
        loads = np.stack([np.ones(len(speed)), drift, place, np.sin(place / ratio), np.cos(place / ratio)], axis=1)
        if recording.has("load_torque"):
            loads = np.column_stack([loads, np.nan_to_num(seen.motion[seen.rows, LOAD][rows])])
        needed = np.stack([seen.acceleration[rows], np.sign(speed), speed], axis=1)
        _, weights = robust_regression(np.hstack([needed, loads]), seen.torque[rows])
        loads, needed = loads * weights[:, None], needed * weights[:, None]
        torque = seen.torque[rows] * weights
        as_read, turned = (least_beside(loads, needed, sign * torque) for sign in (1.0, -1.0))
        alone = least_beside(loads, needed[:, :0], torque)
        sign = 1 if as_read < turned else -1
        least = np.finfo(float).tiny  # where the fit is exact
        gain = float(weights @ weights) * math.log(max(alone, least) / max(min(as_read, turned), least))
        clear = min(as_read, turned) < PART * max(as_read, turned) and gain > CORRELATION * DEPENDS
        yield 0 if not clear or (sign < 0 and brings_energy(recording, seen)) else sign


def _passed_both_ways(seen: Observation) -> np.ndarray | None:
    """Which of the rows (m,) are at places that the motion passes both ways; None if either way has few of them."""
    speed, place = (seen.motion[seen.rows, column] for column in (SPEED, MOTOR_ANGLE))
    forward = speed > 0.0
    if not forward.any() or forward.all():
        return None
    ways = place[forward], place[~forward]
    rows: np.ndarray = (place >= max(way.min() for way in ways)) & (place <= min(way.max() for way in ways))
    few = max(FEWEST, SMALL * int(rows.sum()))
    return rows if min((rows & forward).sum(), (rows & ~forward).sum()) >= few else None

"""A position error in proportion to the speed: the machine follows its setpoint earlier or later than the twin."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from ema_bench_replay.long_columns import pieces

from ..criteria import MOSTLY, PART

POSITIONS = ("motor_position", "output_position")
_MOST_SAMPLES = 3.0
"""The longest shift that a drive's cycle explains; a longer one is a position loop, or a draft whose twin runs away."""


@dataclass(frozen=True)
class ShiftSums:
    """Sums over the rows (n,) of a position's residual r [rad] and the speed v [rad/s] of the same shaft."""

    along: float  # of r v
    speed: float  # of v²
    power: float  # of r²

    @classmethod
    def of(cls, residual: np.ndarray, speed: np.ndarray, ratio: float) -> ShiftSums:
        """The sums of a residual (n,); ``speed`` (n,) is the motor's, ``ratio`` that of its shaft to the encoder's."""
        sums = np.zeros(3)
        for rows in pieces(len(residual)):
            r, v = residual[rows], speed[rows] / ratio
            known = np.isfinite(r) & np.isfinite(v)
            r, v = r[known], v[known]
            sums += (r @ v, v @ v, r @ r)
        return cls(*sums.tolist())


@dataclass(frozen=True)
class SetpointShift:
    """By how many seconds the machine is ahead of the twin (negative: behind), and whether both encoders show it."""

    seconds: float
    samples: float  # the same, in samples of the recordings
    by_both: bool


def setpoint_shift(
    sums: Iterable[Mapping[str, ShiftSums]], period: float, ratio: float, source: str
) -> SetpointShift | None:
    """The shift that makes up most of the position error; ``sums`` are those of each recording, by encoder.

    None if the setpoint does not drive the twin, if the error is mostly something else or the shift longer than a
    drive's cycles, or if the encoders show different errors: then it is an encoder's. ``period`` [s] is that of the
    samples, ``ratio`` the gear ratio.
    """
    if source != "setpoint":
        return None
    totals: dict[str, ShiftSums] = {}
    known = list(sums)
    most = max(map(len, known), default=0)
    for each in known:
        if len(each) < most:  # both encoders are compared over the same rows
            continue
        for name, one in each.items():
            before = totals.get(name, ShiftSums(0.0, 0.0, 0.0))
            totals[name] = ShiftSums(before.along + one.along, before.speed + one.speed, before.power + one.power)
    if not totals:
        return None
    by_both = {*POSITIONS} <= {*totals}
    total = totals["output_position" if by_both else next(iter(totals))]
    if not total.speed > 0.0 or not total.power > 0.0 or total.along**2 < MOSTLY * total.speed * total.power:
        return None
    if by_both:
        output, motor = math.sqrt(total.power), math.sqrt(totals["motor_position"].power) / ratio
        if abs(motor - output) > PART * output:
            return None
    seconds = total.along / total.speed
    samples = abs(seconds) / period
    return SetpointShift(seconds, samples, by_both) if samples <= _MOST_SAMPLES else None

"""A constant error of the output position, from the unknown position of the output in its backlash at the start."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np

from ema_bench_replay.long_columns import median, pieces

from ..criteria import SMALL, TOO_MUCH
from ..model import Model
from ..model.own_units import shown
from ..quantities import quantity
from ..simulation.assembly import assemble
from .where import Stretch


def unknown_start(name: str, model: Model, stretch: Stretch, noise: float, standstill: float) -> Sequence[str]:
    """One sentence if the output is off by the same amount in both directions, within the backlash; else none.

    ``stretch`` holds the residual of the output position, ``noise`` [rad] is that of its sensors. Below ``standstill``
    [rad/s] the motor's direction means little. A wrong backlash width causes different errors in the two directions,
    because positions count from one flank.
    """
    plant = assemble(model).plant[0]
    width = 2.0 * float(plant["gap"] / plant["gear_ratio"])
    if width == 0.0:
        return ()

    def going(way: float) -> Iterator[np.ndarray]:
        for rows in pieces(len(stretch.residual)):
            residual = stretch.residual[rows]
            yield residual[np.isfinite(residual) & (way * stretch.speed[rows] > standstill)]

    forward, backward = (median(partial(going, way)) for way in (1.0, -1.0))
    if math.isnan(forward + backward):
        return ()
    constant, difference = 0.5 * (forward + backward), abs(forward - backward)
    if not TOO_MUCH * noise < abs(constant) <= (1.0 + SMALL) * width or difference > SMALL * abs(constant):
        return ()
    return (
        f"{name}: {quantity(*shown(model, abs(constant), 'rad'))} of its output position's error are the same both "
        "ways: the first sample does not tell where in its play the output stands; begin with the machine's first "
        "motion, or where it moves steadily (--from)",
    )

"""A constant error of the output's position: where in its play the output stood at the first sample was not known."""

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
    """One sentence where a recording's output is off by the same both ways, by no more than the play; else none.

    ``stretch`` holds the output position's residual, ``noise`` [rad] is that of its sensors; below ``standstill``, in
    rad/s, a motor's direction means little. A wrong width of the play errs by one way more than by the other, as
    positions count from one flank.
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

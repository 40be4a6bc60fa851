"""Loads that cancel each other: together they are a curve over the place that neither of them is."""

from __future__ import annotations

import numpy as np

from ...criteria import PART
from ...effects import Trait, catalogue, effects_with
from ...identification.fit import Fit


def opposed(f: Fit) -> str | None:
    """The last added load that another added load cancels, so that their sum has little of its power; None if none is.

    Gravity over a short way is a constant torque and a little of a bend: with a constant load of the other sign the
    bend is left, of whatever cause. An arm with a counterweight has such loads too, but they leave nothing over the
    place; this is for where something is left.
    """
    loads: dict[str, np.ndarray] = {}
    for name, held in f.hypothesis.added.items():
        if held.effect in effects_with(Trait.LOAD):
            size = catalogue()[held.effect].parameters[0].name
            loads[name] = f.hypothesis.instance(name).parameters[size] * f.slopes()[f"effects.{name}.{size}"]
    for name in reversed(loads):
        others = (rows for other, rows in loads.items() if other != name)
        if any(_power(loads[name] + rows) < PART * _power(loads[name]) for rows in others):
            return name
    return None


def _power(rows: np.ndarray) -> float:
    return float(rows @ rows)

"""The bench that the figures are of: its models, and a run of them that books its energies."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from ema_twin_sim.model import Model, load_model
from ema_twin_sim.plant.layout import BENCH
from ema_twin_sim.plant.planetary.geometry import Gearing
from ema_twin_sim.plant.planetary.mesh_table import mesh_table
from ema_twin_sim.simulation.twin import Twin

GEARING = Gearing()
YOUNGS_RATIO = load_model("polito_hff").value("transmission.youngs_modulus_ratio")
TABLE = mesh_table(GEARING, "alternating", YOUNGS_RATIO)
"""Stiffness and arms of the printed gearbox over a mesh cycle."""


@cache
def planetary() -> Model:
    """The planetary train behind an averaged drive: what the gearbox does, without the inverter's ripple."""
    model = load_model("polito_hff")
    return replace(model, kinds={**model.kinds, "drive": "averaged"})


def teeth_alone(coefficient: float) -> Model:
    """The same with no friction but that of its teeth."""
    model = planetary().with_value("transmission.friction_coefficient", coefficient)
    for name in list(model.effects):
        model = model.with_enabled(name, False)
    return model


def follow(twin: Twin, seconds: float, interval: float, **given: float) -> np.ndarray:
    """Samples (n, ``plant.layout.TWIN``) of a started twin every ``interval`` [s], driven by one constant signal."""
    stamps = np.arange(round(seconds / interval) + 1, dtype=np.int64) * round(1e9 * interval)
    bench = np.full((len(stamps), len(BENCH)), np.nan)
    for name, value in given.items():
        bench[:, BENCH.index(name)] = value
    return twin.follow(stamps, bench)

"""The two inertias that replace a planetary train wherever torques are balanced without integrating it.

The unexplained torque, and fits and searches by equation error, need the torque for the measured motion. There a train
is a spring between motor and output, a dead zone, and a loss proportional to the load.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ..model import Model
from ..plant.planetary.geometry import Gearing
from ..plant.planetary.position_balance import all_positions, position_balance
from ..plant.planetary.quasi_static import ToothFriction, static_forces
from ..plant.planetary.torsional_stiffness import torsional_stiffness
from .fidelity import FineParts, gearing_of

TYPICAL_TORQUE = 0.1
"""N m at the sun at which a standard's friction coefficient is evaluated: several times the bench's friction."""
TYPICAL_SPEED = 10.0
"""rad/s of the sun at which it is evaluated."""
POSITIONS = 256


def lump_train(model: Model, plant: np.void, parts: FineParts) -> float:
    """Turn a record of ``plant.layout.PLANT`` into two inertias with the train's stiffness, damping and backlash.

    Returns the train's loss as in ``mesh_friction``: torque lost per transmitted torque, the mean of both directions.
    """
    gearing = gearing_of(model)
    train = parts.train[0]
    stiffness = _stiffness(gearing, parts.table.tobytes(), parts.table.shape)
    relaxation = float(train["damping"][1] / parts.table[1, :-1, :2].sum(axis=1).mean())
    if train["shaft_stiffness"] > 0.0:
        stiffness = 1.0 / (1.0 / stiffness + 1.0 / float(train["shaft_stiffness"]))
    plant["two_inertia"] = 1.0
    plant["contact_stiffness"] = stiffness
    plant["contact_damping"] = stiffness * relaxation
    # a mesh's backlash turns the sun in proportion to its force per sun torque
    weights = 3.0 * np.abs(static_forces(gearing, 1.0))
    plant["gap"] = float(weights @ train["half_play"])
    return _loss(gearing, parts.table.tobytes(), parts.table.shape, tooth_friction(train))


def tooth_friction(train: np.void) -> ToothFriction:
    """Tooth friction of a record of ``plant.planetary.layout.TRAIN``."""
    return ToothFriction(
        int(train["friction_law"]),
        float(train["friction_coefficient"]),
        float(train["viscosity"]),
        float(train["roughness"]),
    )


@lru_cache(maxsize=32)
def _stiffness(gearing: Gearing, table: bytes, shape: tuple[int, ...]) -> float:
    return torsional_stiffness(gearing, np.frombuffer(table).reshape(shape))[0]


@lru_cache(maxsize=256)
def _loss(gearing: Gearing, table: bytes, shape: tuple[int, ...], friction: ToothFriction) -> float:
    meshes = np.frombuffer(table).reshape(shape)
    coefficients = friction.coefficients(gearing, static_forces(gearing, TYPICAL_TORQUE), TYPICAL_SPEED)
    forward, backward = (
        position_balance(gearing, meshes, coefficients, load, all_positions(gearing, POSITIONS)).efficiency
        for load in (TYPICAL_TORQUE, -TYPICAL_TORQUE)
    )
    return 0.5 * ((1.0 / forward - 1.0) + (1.0 - backward))

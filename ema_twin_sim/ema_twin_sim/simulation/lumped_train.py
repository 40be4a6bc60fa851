"""The two inertias that stand for a planetary train wherever torques are balanced without integrating it.

The unexplained torque, and all that fits and searches by equations, ask which torque the measured motion needs: there a
train is a spring between motor and output, a dead zone, and a loss in proportion to the load.
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
"""N m at the sun, at which a standard's coefficient of friction is taken: some times the friction of the bench."""
TYPICAL_SPEED = 10.0
"""rad/s of the sun, at which it is taken."""
POSITIONS = 256


def lump_train(model: Model, plant: np.void, parts: FineParts) -> float:
    """Make a record of ``plant.layout.PLANT`` two inertias with the train's stiffness, damping and play between them.

    Returns the train's loss as ``mesh_friction`` has it: torque lost per torque passed on, the mean of both ways.
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
    # play of a mesh turns the sun by as much as its force is of the sun's torque
    weights = 3.0 * np.abs(static_forces(gearing, 1.0))
    plant["gap"] = float(weights @ train["half_play"])
    return _loss(gearing, parts.table.tobytes(), parts.table.shape, tooth_friction(train))


def tooth_friction(train: np.void) -> ToothFriction:
    """Friction of the teeth of a record of ``plant.planetary.layout.TRAIN``."""
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

"""Static balance of the train in every position: all nine meshes separately, in motion too slow for inertia.

In the balance of mean forces (``quasi_static.py``) every planet carries a third. In fact, friction in the ring meshes
acts on a planet before or after the pitch point, and stiffer planets take more than their share: little compared with
ring forces, but several times the sun's, which are 1/41 of them. For a third of the time a sun mesh pushes the wrong
way, and its losses are 2.6 times those by mean forces, 5.5 times if the load drives (mu = 0.1). The running train
(``train.py``) has the losses of this balance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .displacements import CARRIER, FIRST_PLANET, OUTPUT, SUN, displacements
from .geometry import OUTPUT_MESH, PLANETS, RING_MESH, SUN_MESH, Gearing
from .mesh_table import AHEAD, ENTERING, FIRST_ARM, SECOND_ARM, Array
from .phases import mesh_cycles, opposite_flank

SIGN_CHANGES = 30
"""Maximum iterations in which meshes may change the pushing side; three are usual."""


@dataclass(frozen=True)
class PositionBalance:
    """Balance at (n,) positions of the sun: its torque [N m], the meshes' forces [N] (n, 3 types, 3 planets).

    ``efficiency`` is that of slow motion through all positions at constant speed and load.
    """

    sun_torque: Array
    forces: Array
    efficiency: float


def position_balance(
    gearing: Gearing, table: Array, coefficients: Array, load: float, positions: Array
) -> PositionBalance:
    """Balance while the sun turns slowly forwards against ``load`` [N m at the fast shaft]; negative loads drive.

    Friction ``coefficients`` (3,) of the mesh types, ``positions`` (n,) of the sun [rad]; the other wheels are where a
    rigid train has them. ``table`` is ``mesh_table``'s.
    """
    deflection = displacements(gearing).reshape(PLANETS, PLANETS, -1)  # (meshes, planets, coordinates)
    flank = opposite_flank(gearing)[:, np.newaxis]
    at = np.stack([mesh_cycles(gearing, s, s * gearing.carrier_ratio, s / gearing.ratio) for s in positions])
    push = np.sign(load) * np.broadcast_to(np.array([1.0, 1.0, -1.0])[:, np.newaxis], at.shape)
    given = np.zeros(deflection.shape[-1])
    given[OUTPUT] = load * gearing.ratio
    free = np.arange(deflection.shape[-1]) != SUN
    for _ in range(SIGN_CHANGES):
        values = _read(table, np.where(push > 0.0, at, flank - at))
        stiffness = values[..., ENTERING] + values[..., AHEAD]
        sliding = _sliding(values[..., FIRST_ARM], values[..., SECOND_ARM], deflection.shape[-1])
        # the torque of a mesh on each coordinate, per newton
        torque = -(deflection + coefficients[:, np.newaxis, np.newaxis] * push[..., np.newaxis] * sliding)
        matrix = np.einsum("nmpi,nmp,mpj->nij", torque, stiffness, deflection)
        turned = np.zeros((len(positions), deflection.shape[-1]))
        turned[:, free] = np.linalg.solve(
            matrix[:, free][:, :, free], np.broadcast_to(given[free], (len(positions), free.sum()))[..., np.newaxis]
        )[..., 0]
        forces = stiffness * np.einsum("mpj,nj->nmp", deflection, turned)
        now = np.where(forces >= 0.0, 1.0, -1.0)
        if np.array_equal(now, push):
            break
        push = now
    sun_torque = -np.einsum("nj,nj->n", matrix[:, SUN], turned)
    mean = float(sun_torque.mean())
    return PositionBalance(sun_torque, forces, load / mean if load > 0.0 else mean / load)


def first_locking_coefficient(gearing: Gearing, table: Array, count: int = 500, accuracy: float = 1e-4) -> float:
    """Smallest friction coefficient at which the output cannot drive the sun in some position; infinite beyond 1.

    A slow load stops there, before the mean of all positions locks.
    """
    positions = all_positions(gearing, count)

    def locks(coefficient: float) -> bool:
        return position_balance(gearing, table, np.full(3, coefficient), -1.0, positions).sun_torque.max() >= 0.0

    low, high = 0.0, 1.0
    if not locks(high):
        return float("inf")
    while high - low > accuracy:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if locks(middle) else (middle, high)
    return high


def all_positions(gearing: Gearing, count: int = 2000) -> Array:
    """Positions [rad] of the sun spread over a turn of the output ring, after which everything repeats."""
    return np.linspace(0.0, 2.0 * np.pi * abs(gearing.ratio), count, endpoint=False)


def _read(table: Array, cycles: Array) -> Array:
    """Rows of the table at ``cycles`` (n, 3, 3): (n, 3, 3, 4)."""
    at = (cycles % 1.0) * (table.shape[1] - 1)
    low = np.minimum(at.astype(int), table.shape[1] - 2)
    share = (at - low)[..., np.newaxis]
    mesh = np.arange(PLANETS)[:, np.newaxis]
    return table[mesh, low] + share * (table[mesh, low + 1] - table[mesh, low])


def _sliding(first: Array, second: Array, coordinates: int) -> Array:
    """dV/dq' of each mesh (n, 3, 3, coordinates), planets relative to the carrier."""
    rows = np.zeros((*first.shape, coordinates))
    for planet in range(PLANETS):
        own = FIRST_PLANET + planet
        rows[:, SUN_MESH, planet, SUN] = first[:, SUN_MESH, planet]
        rows[:, SUN_MESH, planet, CARRIER] = -first[:, SUN_MESH, planet]
        rows[:, SUN_MESH, planet, own] = -second[:, SUN_MESH, planet]
        rows[:, RING_MESH, planet, CARRIER] = -second[:, RING_MESH, planet]
        rows[:, RING_MESH, planet, own] = first[:, RING_MESH, planet]
        rows[:, OUTPUT_MESH, planet, CARRIER] = -second[:, OUTPUT_MESH, planet]
        rows[:, OUTPUT_MESH, planet, OUTPUT] = second[:, OUTPUT_MESH, planet]
        rows[:, OUTPUT_MESH, planet, own] = first[:, OUTPUT_MESH, planet]
    return rows

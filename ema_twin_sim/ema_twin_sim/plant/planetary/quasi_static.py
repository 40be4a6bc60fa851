"""Forces, losses and self-locking of the train in slow steady motion, from the balance of its wheels.

Without inertia, and with the mean friction arms over a mesh cycle. With friction, the force F of a mesh acts on its two
wheels with the arms a_j = r_j + mu sgn(F) sgn(V) B_j (``mesh_table``): the thesis's eqs 3.42 to 3.47 by virtual work,
extended to the carrier and the output ring. V is never negative while the sun turns forwards. For each planet

    planet   a_s2 F_s = a_r1 F_r + a_o1 F_o            sun     T_s = 3 a_s1 F_s
    carrier  a_s1 F_s + a_r2 F_r + a_o2 F_o = 0        output  T_o = -3 a_o2 F_o
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .friction_coefficient import CONSTANT, friction_coefficient
from .geometry import OUTPUT_MESH, PLANETS, RING_MESH, SUN_MESH, Gearing
from .mesh_table import mean_arms

MOST_ROUNDS = 200  # iterations between coefficients and forces; with exponents 0.2 and 0.25 they converge in about 20
SETTLED = 1e-14  # of the largest force

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ToothFriction:
    """Tooth friction: its law (``friction_coefficient``), constant coefficient, viscosity [Pa s], R_a [m]."""

    law: int = CONSTANT
    constant: float = 0.0
    viscosity: float = 0.0
    roughness: float = 0.0

    def coefficients(self, gearing: Gearing, forces: Array, speed: float) -> Array:
        """Coefficients (3,) of the kinds of mesh at their forces [N] while the sun turns at ``speed`` [rad/s]."""
        rolling = sum_speeds(gearing, speed)
        return np.array(
            [
                friction_coefficient(
                    self.law,
                    self.constant,
                    abs(force) / gearing.face_width,
                    rolling[mesh],
                    gearing.meshes[mesh].equivalent_radius,
                    self.viscosity,
                    self.roughness,
                )
                for mesh, force in enumerate(forces)
            ]
        )


@dataclass(frozen=True)
class Balance:
    """Static balance of the train while its sun turns forwards.

    ``sun_power`` [W] enters at the sun and ``output_power`` leaves at the output ring: both negative if the output
    drives. ``sun_torque`` [N m] acts on the sun, ``output_torque`` on the load. ``forces`` [N] are those of one
    planet's meshes, ``losses`` [W] those of each kind of mesh over all planets; order as in ``Gearing.meshes``.
    """

    output_drives: bool
    sun_torque: float
    output_torque: float
    sun_power: float
    output_power: float
    coefficients: Array
    forces: Array
    losses: Array

    @property
    def efficiency(self) -> float:
        """Output power over input power. Negative if the output drives and the sun must help: self-locking."""
        given, taken = (
            (self.sun_power, self.output_power) if self.output_drives else (self.output_power, self.sun_power)
        )
        return given / taken

    @property
    def loss_shares(self) -> Array:
        """Share of each kind of mesh in all losses; zeros without losses."""
        return self.losses / (self.losses.sum() or 1.0)


def static_forces(gearing: Gearing, sun_torque: float) -> Array:
    """Forces [N] of one planet's meshes without friction, at a torque on the sun [N m]: here 1 : 41 : -42."""
    forces = _proportions(_radii(gearing))
    return forces * sun_torque / (PLANETS * gearing.sun_radius * forces[SUN_MESH])


def sum_speeds(gearing: Gearing, speed: float) -> Array:
    """Sums of both flanks' rolling speeds [m/s] at the pitch point of each kind of mesh, relative to the carrier.

    Each flank rolls at its base circle's speed times tan(pressure angle); the base circles of a mesh have equal speeds.
    """
    planet = abs(speed) * gearing.planet_ratio
    base = np.array([gearing.planet_radius, gearing.planet_radius, gearing.second_planet_radius]) * planet
    return 2.0 * np.tan(gearing.pressure_angle) * base


def sliding_speeds(gearing: Gearing, arms: Array, speed: float) -> Array:
    """Sliding speeds [m/s] of each kind of mesh in rigid motion, mean over a cycle (V of ``mesh_table``)."""
    planet, carrier, output = gearing.planet_ratio, gearing.carrier_ratio, 1.0 / gearing.ratio
    turning = np.array([[1.0 - carrier, planet], [planet, carrier], [planet, carrier - output]])
    return speed * (turning[:, 0] * arms[:, 0] - turning[:, 1] * arms[:, 1])


def balance(
    gearing: Gearing,
    table: Array,
    friction: ToothFriction,
    torque: float,
    speed: float = 1.0,
    output_drives: bool = False,
) -> Balance:
    """Balance of the train with the sun turning at ``speed`` > 0 [rad/s], driven by ``torque`` > 0 [N m].

    The torque drives the sun, or (``output_drives``) the output ring, which then turns the sun against a load, or with
    its help if the train is self-locking. ``table`` is ``mesh_table``'s.
    """
    radii, arms = _radii(gearing), mean_arms(table)
    drives = -1.0 if output_drives else 1.0
    forces = static_forces(gearing, torque / abs(gearing.ratio) if output_drives else torque) * drives
    coefficients = friction.coefficients(gearing, forces, speed)
    for _ in range(MOST_ROUNDS):
        acting = radii + (coefficients * np.sign(forces))[:, np.newaxis] * arms
        new = _proportions(acting)
        if output_drives:
            new *= -np.sign(gearing.ratio) * torque / (-PLANETS * acting[OUTPUT_MESH, 1] * new[OUTPUT_MESH])
        else:
            new *= torque / (PLANETS * acting[SUN_MESH, 0] * new[SUN_MESH])
        change = np.abs(new - forces).max()
        forces = new
        if change <= SETTLED * np.abs(forces).max():
            break
        coefficients = friction.coefficients(gearing, forces, speed)
    sun_torque = PLANETS * acting[SUN_MESH, 0] * forces[SUN_MESH]
    output_torque = -PLANETS * acting[OUTPUT_MESH, 1] * forces[OUTPUT_MESH]
    losses = PLANETS * coefficients * np.abs(forces) * sliding_speeds(gearing, arms, speed)
    return Balance(
        output_drives,
        float(sun_torque),
        float(output_torque),
        float(sun_torque * speed),
        float(output_torque * speed / gearing.ratio),
        coefficients,
        forces,
        losses,
    )


def efficiencies(
    gearing: Gearing, table: Array, friction: ToothFriction, torques: Array, speeds: Array, output_drives: bool = False
) -> Array:
    """Efficiency (torques, speeds) over driving torques [N m] and speeds of the sun [rad/s] (``balance``)."""
    return np.array(
        [
            [balance(gearing, table, friction, torque, speed, output_drives).efficiency for speed in speeds]
            for torque in torques
        ]
    )


def self_locking_coefficient(gearing: Gearing, table: Array) -> float:
    """Smallest friction coefficient at which the output cannot drive the sun; infinite if it always can.

    There the sun's force vanishes: a_r1 a_o2 = a_o1 a_r2, a quadratic equation in the coefficient, with the force signs
    of a driving output.
    """
    radii, arms = _radii(gearing), mean_arms(table)
    sloped = -np.sign(static_forces(gearing, 1.0))[:, np.newaxis] * arms
    ring, output = (np.polynomial.Polynomial([radii[m, 0], sloped[m, 0]]) for m in (RING_MESH, OUTPUT_MESH))
    on_carrier, on_output = (np.polynomial.Polynomial([radii[m, 1], sloped[m, 1]]) for m in (RING_MESH, OUTPUT_MESH))
    roots = (ring * on_output - output * on_carrier).roots()
    locking = [float(root.real) for root in roots if root.imag == 0.0 and root.real > 0.0]
    return min(locking, default=float("inf"))


def _radii(gearing: Gearing) -> Array:
    """Base radii [m] (3 meshes, 2 wheels): the arms of the mesh forces without friction."""
    return np.array([[mesh.first_base_radius, mesh.second_base_radius] for mesh in gearing.meshes])


def _proportions(acting: Array) -> Array:
    """Forces of one planet's meshes up to a common factor, from the balance of planet and carrier.

    No division, since the sun's force vanishes if the train locks.
    """
    (s1, s2), (r1, r2), (o1, o2) = acting
    return np.array([r1 * o2 - o1 * r2, s2 * o2 + o1 * s1, -(r1 * s1 + r2 * s2)])

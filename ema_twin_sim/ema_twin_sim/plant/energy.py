"""Energy accounting of a run: every work and loss is recorded separately in each step.

Each entry is computed from its own equation, never as a remainder, so that the balance

    link + stiffness change = losses + load + change of stored energy

checks the plant (tests/plant/test_energy.py), and the losses are a result of their own. The work of a torque uses the
mean of the speeds before and after a step, which is exact for the kinetic energy. Finer fidelities only.
"""

import math

from numba import njit

from .compiled import inlined
from .planetary.layout import LANE, PLANETS, ROW

ENERGIES = (
    "link",  # from the DC link
    "winding",  # lost in windings and switches
    "air_gap",  # work of the windings' torque
    "motor",  # work of the torque on the motor's shaft
    "effects",  # work against effects on the motor side
    "motor_viscous",
    "motor_dry",
    "shaft",  # lost and stored in the shaft from motor to sun
    "mesh_damping",
    "sun_mesh_friction",  # work against tooth friction; the tangential elastic part before sliding is stored
    "ring_mesh_friction",
    "output_mesh_friction",
    "springs",  # work on the meshes' springs
    "stiffness_change",  # put into the springs by changes of stiffness and run-out as the wheels turn
    "output_viscous",
    "output_dry",
    "load",  # work on the load, by effects on the output side
)
"""Entries [J], since the start of a run."""

_AT = {name: k for k, name in enumerate(ENERGIES)}
LINK, WINDING, AIR_GAP, MOTOR = _AT["link"], _AT["winding"], _AT["air_gap"], _AT["motor"]
EFFECTS, MOTOR_VISCOUS, MOTOR_DRY, SHAFT = _AT["effects"], _AT["motor_viscous"], _AT["motor_dry"], _AT["shaft"]
MESH_DAMPING, MESH_FRICTION = _AT["mesh_damping"], _AT["sun_mesh_friction"]
SPRINGS, STIFFNESS_CHANGE = _AT["springs"], _AT["stiffness_change"]
OUTPUT_VISCOUS, OUTPUT_DRY, LOAD = _AT["output_viscous"], _AT["output_dry"], _AT["load"]

_SPIN, _SPIN_SPEED, _SPEED_BEFORE = ROW["SPIN"], ROW["SPIN_SPEED"], ROW["SPEED_BEFORE"]
_STIFFNESS, _ARM_1, _ARM_2 = ROW["STIFFNESS_SUN"], ROW["ARM_1_SUN"], ROW["ARM_2_SUN"]
_RUNOUT, _FORCE, _FRICTION, _DAMPED = ROW["RUNOUT_SUN"], ROW["FORCE_SUN"], ROW["FRICTION_SUN"], ROW["DAMPED_SUN"]


@njit(error_model="numpy")
def account_drive(energies, h, speed, air_gap_torque, link_power, loss):
    """Record one step of the switching drive; ``speed`` [rad/s] is the one used for its back-EMF."""
    energies[LINK] += h * link_power
    energies[WINDING] += h * loss
    energies[AIR_GAP] += h * air_gap_torque * speed


@njit(error_model="numpy")
def friction_energies(energies, viscous_entry, dry_entry, h, before, after, pushing, viscous, dry, inertia):
    """Record the friction of one inertia over a step, from its own law; return the mean speed [rad/s].

    ``pushing`` [N m] is the torque without friction.
    """
    mean = 0.5 * (before + after)
    energies[viscous_entry] += h * viscous * after * mean
    stopping = inertia * before / h + pushing  # torque that stops the shaft within the step
    friction = stopping if after == 0.0 else math.copysign(dry, after)
    energies[dry_entry] += h * friction * mean
    return mean


@inlined
def account_motor(energies, h, before, after, drive_torque, net, passed, viscous, dry, inertia):
    """Record a step of the motor shaft under ``net`` [N m] minus the ``passed`` torque; return its mean speed [rad/s].

    The difference between ``drive_torque`` and ``net`` is taken by effects.
    """
    mean = friction_energies(
        energies, MOTOR_VISCOUS, MOTOR_DRY, h, before, after, net - passed, viscous, dry, inertia
    )  # fmt: skip
    energies[MOTOR] += h * drive_torque * mean
    energies[EFFECTS] += h * (drive_torque - net) * mean
    return mean


@inlined
def account_output(energies, h, before, after, passed, load, viscous, dry, inertia):
    """Record a step of the output shaft, driven by the ``passed`` torque against its ``load`` [N m]."""
    mean = friction_energies(
        energies, OUTPUT_VISCOUS, OUTPUT_DRY, h, before, after, passed - load, viscous, dry, inertia
    )  # fmt: skip
    energies[LOAD] += h * load * mean


@njit(error_model="numpy")
def keep_speeds(lanes, moving):
    """Store the planets' and the carrier's speeds before a step."""
    for planet in range(PLANETS):
        lanes[_SPEED_BEFORE + planet] = lanes[_SPIN_SPEED + planet]
    moving.speed_before = moving.carrier_speed


@njit(error_model="numpy")
def _deflections(train, mesh, sun, carrier, planet, output):
    """Deflection [m] of a mesh from the wheels' angles [rad], or its speed from their speeds."""
    if mesh == 0:
        return train.sun_radius * (sun - carrier) - train.planet_radius * (carrier - planet)
    if mesh == 1:
        return train.planet_radius * (carrier - planet) - train.ring_radius * carrier
    return train.second_planet_radius * (carrier - planet) - train.output_ring_radius * (carrier - output)


@njit(error_model="numpy")
def _slidings(mesh, arm_1, arm_2, sun, carrier, planet, output):
    if mesh == 0:
        return arm_1 * (sun - carrier) - arm_2 * (carrier - planet)
    if mesh == 1:
        return arm_1 * (carrier - planet) - arm_2 * carrier
    return arm_1 * (carrier - planet) - arm_2 * (carrier - output)


@njit(error_model="numpy")
def stored_in_meshes(train, moving, lanes, sun, sun_speed, output, output_speed, h):
    """Energy [J] in the meshes' springs at the start of a step of ``h`` [s], from its angles [rad] and speeds [rad/s].

    That is 1/2 k x+ x- with the deflections half a step ahead and half a step back: drift, kick, drift uses the force
    at the former and leaves exactly the work 1/2 k (x^2 - (h v / 2)^2), while 1/2 k x^2 is off by h^2.
    """
    half = 0.5 * h
    stored = 0.0
    carrier, carrier_speed = moving.carrier_angle, moving.carrier_speed
    for mesh in range(3):
        play = train.half_play[mesh]
        for planet in range(PLANETS):
            lane = LANE * mesh + planet
            depth = _deflections(train, mesh, sun, carrier, lanes[_SPIN + planet], output) + lanes[_RUNOUT + lane]
            rate = half * _deflections(train, mesh, sun_speed, carrier_speed, lanes[_SPIN_SPEED + planet], output_speed)
            stored += 0.5 * lanes[_STIFFNESS + lane] * _beyond(depth + rate, play) * _beyond(depth - rate, play)
    return stored


@njit(error_model="numpy")
def _beyond(depth, play):
    return depth - play if depth > play else (depth + play if depth < -play else 0.0)


@njit(error_model="numpy")
def account_meshes(energies, h, train, moving, lanes, sun_before, sun_after, output_before, output_after):
    """Record a step of the meshes: springs, dampers, friction. The output's speeds are those of the slow shaft."""
    sun = 0.5 * (sun_before + sun_after)
    output = 0.5 * (output_before + output_after)
    carrier = 0.5 * (moving.speed_before + moving.carrier_speed)
    for planet in range(PLANETS):
        before, after = lanes[_SPEED_BEFORE + planet], lanes[_SPIN_SPEED + planet]
        spin = 0.5 * (before + after)
        for mesh in range(3):
            lane = LANE * mesh + planet
            depth_speed = _deflections(train, mesh, sun, carrier, spin, output)
            sliding = _slidings(mesh, lanes[_ARM_1 + lane], lanes[_ARM_2 + lane], sun, carrier, spin, output)
            energies[MESH_DAMPING] += h * lanes[_DAMPED + lane] * depth_speed
            energies[SPRINGS] += h * (lanes[_FORCE + lane] - lanes[_DAMPED + lane]) * depth_speed
            energies[MESH_FRICTION + mesh] += h * lanes[_FRICTION + lane] * sliding

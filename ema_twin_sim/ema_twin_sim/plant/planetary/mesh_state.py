"""State of the meshes at the wheels' present angles: stiffness, friction arms, damaged teeth, run-out, friction.

All change over the mesh cycle, thousands of steps long: they are updated once a mesh has moved by ``refresh`` cycles.
The friction coefficient, the mean over a mesh cycle as in the thesis (3.4.2), is updated once a control cycle.
"""

import math

from numba import njit

from ..compiled import compiled
from ..energy import STIFFNESS_CHANGE, stored_in_meshes
from .friction_coefficient import friction_coefficient
from .layout import LANE, PLANETS, ROW, TURN

_STIFFNESS, _ARM_1, _ARM_2 = ROW["STIFFNESS_SUN"], ROW["ARM_1_SUN"], ROW["ARM_2_SUN"]
_RUNOUT, _FORCE = ROW["RUNOUT_SUN"], ROW["FORCE_SUN"]
_THIRD = 1.0 / PLANETS


@compiled
def mesh_cycles(constants, sun, carrier, output):
    """Mesh cycles (sun, ring, output) of the first planet from the wheels' travel [rad]; (3.52-3.60) use time.

    ``constants`` are ``TrainConstants``.
    """
    return (
        constants.sun_cycles * (sun - carrier) + constants.sun_cycle_origin,
        constants.ring_cycles * carrier + constants.ring_cycle_origin,
        constants.output_cycles * (carrier - output) + constants.output_cycle_origin,
    )


@compiled
def moved_on(train, moving, cycles):
    """Whether a mesh has moved far enough since the last update for another."""
    return (
        math.fabs(cycles[0] - moving.mesh_read[0]) >= train.refresh
        or math.fabs(cycles[1] - moving.mesh_read[1]) >= train.refresh
        or math.fabs(cycles[2] - moving.mesh_read[2]) >= train.refresh
    )


@njit(error_model="numpy")
def _tooth(cycles, teeth):
    return math.floor(cycles) - teeth * math.floor(math.floor(cycles) / teeth)


@njit(error_model="numpy")
def _left(train, wheel, tooth, teeth, leading):
    """Remaining share of a pair's stiffness: reduced if its tooth of this wheel is the damaged one.

    ``leading`` is the pair that came into contact last; the one before it is one tooth behind.
    """
    damage = train.tooth_damage[wheel]
    if damage == 0.0:
        return 1.0
    damaged = train.damaged_tooth[wheel]
    at = tooth if leading else tooth - 1.0
    at = at + teeth if at < 0.0 else at
    return 1.0 - damage if at == damaged else 1.0


@njit(error_model="numpy")
def read_meshes(train, moving, lanes, table, cycles):
    """Update stiffness, arms and run-out of all meshes in ``lanes``.

    ``cycles`` are ``mesh_cycles``, ``table`` float64 (3, points + 1, 4) is ``mesh_table.mesh_table``'s.
    """
    for mesh in range(3):
        moving.mesh_read[mesh] = cycles[mesh]
    points = table.shape[1] - 1
    healthy = (
        train.tooth_damage[0] == 0.0
        and train.tooth_damage[1] == 0.0
        and train.tooth_damage[2] == 0.0
        and train.tooth_damage[3] == 0.0
    )
    for mesh in range(3):
        # planets are numbered in positive direction: a later one meets the sun's earlier teeth, the rings' later ones
        teeth = -train.sun_teeth if mesh == 0 else (train.ring_teeth if mesh == 1 else train.output_ring_teeth)
        for planet in range(PLANETS):
            x = cycles[mesh] + teeth * (planet * _THIRD)
            # a negative force acts on the opposite flanks, which pass their line of action in reverse
            place = x if lanes[_FORCE + LANE * mesh + planet] >= 0.0 else train.opposite_flank[mesh] - x
            at = (place - math.floor(place)) * points
            low = int(at)
            low = points - 1 if low >= points else low
            share = at - low
            first = table[mesh, low, 0] + share * (table[mesh, low + 1, 0] - table[mesh, low, 0])
            second = table[mesh, low, 1] + share * (table[mesh, low + 1, 1] - table[mesh, low, 1])
            if not healthy:
                if mesh == 0:
                    tooth = _tooth(x, train.sun_teeth)
                    first *= _left(train, 0, tooth, train.sun_teeth, True)
                    second *= _left(train, 0, tooth, train.sun_teeth, False)
                elif mesh == 1:
                    tooth = _tooth(x, train.ring_teeth)
                    first *= _left(train, 2, tooth, train.ring_teeth, True)
                    second *= _left(train, 2, tooth, train.ring_teeth, False)
                else:
                    tooth = _tooth(x, train.output_ring_teeth)
                    first *= _left(train, 3, tooth, train.output_ring_teeth, True)
                    second *= _left(train, 3, tooth, train.output_ring_teeth, False)
                if planet == 0 and mesh < 2:
                    # a planet's tooth meets the ring half a turn after the sun
                    across = 0.0 if mesh == 0 else math.floor(0.5 * train.planet_teeth)
                    tooth = _tooth(x - across, train.planet_teeth)
                    first *= _left(train, 1, tooth, train.planet_teeth, True)
                    second *= _left(train, 1, tooth, train.planet_teeth, False)
            lane = LANE * mesh + planet
            lanes[_STIFFNESS + lane] = first + second
            lanes[_ARM_1 + lane] = table[mesh, low, 2] + share * (table[mesh, low + 1, 2] - table[mesh, low, 2])
            lanes[_ARM_2 + lane] = table[mesh, low, 3] + share * (table[mesh, low + 1, 3] - table[mesh, low, 3])
    _read_runout(train, lanes, cycles)


@njit(error_model="numpy")
def _read_runout(train, lanes, cycles):
    """Run-out [m] of each mesh: displacement of an eccentric wheel's teeth along the line of action.

    A planet whose pitch circle is off its axis by e, at the angle b from the carrier's radius, moves by e sin b in the
    carrier's direction and by e cos b outwards. Moving in the carrier's direction, it moves away from the sun's teeth
    and from the ring's; moving outwards, away from the sun's and into the ring's: with a pressure angle a

        delta_s = -e (cos a sin b + sin a cos b) = -e sin(b + a)
        delta_r = -e (cos a sin b - sin a cos b) = -e sin(b - a)

    (Lin and Parker, "Analytical characterization of the unique properties of planetary gear free vibration", J. Vib.
    Acoust. 121, 1999, eq. 1). So both meshes have the same sign, 2 a apart in the planet's turn: the ring meets the
    planet half a turn from the sun, but on its other flank. With the phase p of the sun's mesh and the planet's turn
    t = -b against the carrier, these are e sin(t + p) and e sin(t + p + 2 a). The flanks are those that carry a load
    forward; on the others the outward part would change its sign, which is neglected.
    """
    if train.runout[0] == 0.0 and train.runout[1] == 0.0 and train.runout[2] == 0.0:
        return
    carrier = TURN * (cycles[1] - train.mesh_phase[1]) / train.ring_teeth
    sun_to_carrier = TURN * (cycles[0] - train.mesh_phase[0]) / train.sun_teeth
    carrier_to_output = TURN * (cycles[2] - train.mesh_phase[2]) / train.output_ring_teeth
    planet_turn = carrier * (train.ring_radius / train.planet_radius) + train.runout_phase[1]
    for planet in range(PLANETS):
        place = planet * _THIRD * TURN
        of_planet = train.runout[1] if planet == 0 else 0.0
        lanes[_RUNOUT + planet] = train.runout[0] * math.sin(
            sun_to_carrier - place + train.runout_phase[0]
        ) + of_planet * math.sin(planet_turn)
        lanes[_RUNOUT + LANE + planet] = of_planet * math.sin(planet_turn + 2.0 * train.pressure_angle)
        lanes[_RUNOUT + 2 * LANE + planet] = train.runout[2] * math.sin(
            carrier_to_output + place + train.runout_phase[2]
        )


@njit(error_model="numpy")
def read_friction(train, moving, lanes, sun_speed, output_speed):
    """Update the friction coefficient of each mesh type at the present forces and speeds."""
    carrier = moving.carrier_speed
    rolling = 2.0 * math.tan(
        train.pressure_angle
    )  # sum of both flanks' speeds at the pitch point, relative to that of the base circle
    for mesh in range(3):
        force = 0.0
        for planet in range(PLANETS):
            force += math.fabs(lanes[_FORCE + LANE * mesh + planet])
        radius = train.sun_radius if mesh == 0 else (train.ring_radius if mesh == 1 else train.output_ring_radius)
        relative = sun_speed - carrier if mesh == 0 else (carrier if mesh == 1 else carrier - output_speed)
        moving.friction_coefficient[mesh] = friction_coefficient(
            train.friction_law,
            train.friction_coefficient,
            force * _THIRD / train.face_width,
            rolling * radius * math.fabs(relative),
            train.pitch_curvature[mesh],
            train.viscosity,
            train.roughness,
        )


@compiled
def follow_meshes(
    constants, train, moving, lanes, table, sun, sun_speed, carrier, output, output_speed, h, energies, accounting
):
    """Update the meshes if one has moved far enough, at angles [rad] of the middle of a step of ``h`` [s].

    ``accounting`` records the energy of the change of stiffness.
    """
    cycles = mesh_cycles(constants, sun, carrier, output)
    if moved_on(train, moving, cycles):
        sun -= 0.5 * h * sun_speed
        output -= 0.5 * h * output_speed
        if accounting:
            energies[STIFFNESS_CHANGE] -= stored_in_meshes(
                train, moving, lanes, sun, sun_speed, output, output_speed, h
            )
        read_meshes(train, moving, lanes, table, cycles)
        if accounting:
            energies[STIFFNESS_CHANGE] += stored_in_meshes(
                train, moving, lanes, sun, sun_speed, output, output_speed, h
            )

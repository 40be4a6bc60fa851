"""One step of the planetary 3K train between a motor and an output: sun, three planet pairs, carrier, output ring.

Thesis, chapter 3, complete and corrected (the thesis stops at the first stage and divides by 124). With W_i a planet's
absolute spin, so that it turns by theta_c - phi_i against the carrier, the mesh deflections (3.17-3.28) are

    delta_s,i = r_s (theta_s - theta_c) - r_p (theta_c - phi_i)
    delta_r,i = r_p (theta_c - phi_i) - r_r theta_c
    delta_o,i = r_p2 (theta_c - phi_i) - r_o (theta_c - theta_o)

In these coordinates inertia is diagonal: a planet's spin, and the carrier with its planets' orbiting masses (3.5-3.8
omit that the carrier moves the planets). Per mesh F = k f(delta) + c delta', f the dead zone of (3.4): the thesis
prints k where k f(delta) is meant, and "f = 1" for f(delta) = delta. Torques are -F d(delta)/d(coordinate) (3.3,
3.5-3.8). A mesh can pull as well as push: the output ring meshes carry -42 times the sun's force.

Friction acts perpendicular to the line of action (3.29-3.30), on each coordinate by virtual work: with the weighted
sliding speed V = sum of dV/dq' q', a force f gives -f dV/dq'. (3.40-3.47 subtract the carrier's speed twice, omit the
ring, and give the planet the sun's arm: friction then adds power.) Instead of mu |F| sgn(V), the contact is elastic
tangentially, with a stiffness of its own (Mindlin, "Compliance of elastic bodies in contact", 1949: about 0.8 of the
normal one), until f reaches mu |F|, where it slides. So teeth stick without creeping, a train locked by a load stays
locked, and planets so light that one step of mu |F| would reverse their sliding do not chatter.

A spring k(theta) whose stiffness rises as its wheels turn also opposes them with 1/2 delta^2 dk/dtheta. Like the
thesis, this model omits it, so a tooth that comes into contact under load adds its energy 1/2 k delta^2, and one that
leaves removes it. This is recorded as ``stiffness_change`` when the stiffness is updated (``energy.py``), and with it
the energies balance. It is under 2 % of the energy through the bench's train (docs/physics.md).

Step: drift, kick, drift as in ``transmission.py``.
"""

import math

from ..compiled import compiled
from .layout import LANE, ROW

SPIN, SPIN_SPEED = ROW["SPIN"], ROW["SPIN_SPEED"]
STIFFNESS_SUN, STIFFNESS_RING, STIFFNESS_OUT = ROW["STIFFNESS_SUN"], ROW["STIFFNESS_RING"], ROW["STIFFNESS_OUT"]
DAMPING_SUN, DAMPING_RING, DAMPING_OUT = ROW["DAMPING_SUN"], ROW["DAMPING_RING"], ROW["DAMPING_OUT"]
ARM_1_SUN, ARM_1_RING, ARM_1_OUT = ROW["ARM_1_SUN"], ROW["ARM_1_RING"], ROW["ARM_1_OUT"]
ARM_2_SUN, ARM_2_RING, ARM_2_OUT = ROW["ARM_2_SUN"], ROW["ARM_2_RING"], ROW["ARM_2_OUT"]
RUNOUT_SUN, RUNOUT_RING, RUNOUT_OUT = ROW["RUNOUT_SUN"], ROW["RUNOUT_RING"], ROW["RUNOUT_OUT"]
FORCE_SUN, FORCE_RING, FORCE_OUT = ROW["FORCE_SUN"], ROW["FORCE_RING"], ROW["FORCE_OUT"]
FRICTION_SUN, FRICTION_RING, FRICTION_OUT = ROW["FRICTION_SUN"], ROW["FRICTION_RING"], ROW["FRICTION_OUT"]
DAMPED_SUN, DAMPED_RING, DAMPED_OUT = ROW["DAMPED_SUN"], ROW["DAMPED_RING"], ROW["DAMPED_OUT"]
ON_SUN, ON_CARRIER, ON_OUTPUT = ROW["ON_SUN"], ROW["ON_CARRIER"], ROW["ON_OUTPUT"]


@compiled
def _elastic(depth, stiffness, half_play):
    """Elastic force [N] of a mesh over its dead zone (3.4)."""
    beyond = depth - half_play if depth > half_play else (depth + half_play if depth < -half_play else 0.0)
    return stiffness * beyond


@compiled
def _rubbing(force, level):
    """Friction [N] of a mesh, limited to the sliding level."""
    return level if force > level else (-level if force < -level else force)


@compiled
def train_step(
    constants, friction_coefficient, lanes, sun_angle, sun_speed, carrier, carrier_speed, output_angle, output_speed
):
    """Advance planets and carrier by a step; return the train's torques [N m] on sun and output ring.

    Also returns the carrier's angle [rad] and speed [rad/s] after the step. ``constants`` are ``TrainConstants``.
    Angles of sun, carrier and output ring are those in the middle of the step, speeds those before it; the output is
    the slow shaft. ``lanes`` hold the planets and the last state of the meshes (``mesh_state.py``).
    """
    r_s = constants.sun_radius
    r_p = constants.planet_radius
    r_p2 = constants.second_planet_radius
    r_o = constants.output_ring_radius
    r_sp = constants.carrier_arm_sun
    r_pr = constants.carrier_arm_ring
    r_po = constants.carrier_arm_output
    play_s = constants.half_play_sun
    play_r = constants.half_play_ring
    play_o = constants.half_play_output
    mu_s = friction_coefficient[0]
    mu_r = friction_coefficient[1]
    mu_o = friction_coefficient[2]
    across_s = constants.across_sun
    across_r = constants.across_ring
    across_o = constants.across_output
    half = 0.5 * constants.step
    # common to all planets' meshes
    d_s = r_s * sun_angle - r_sp * carrier
    d_r = r_pr * carrier
    d_o = r_po * carrier + r_o * output_angle
    v_s = r_s * sun_speed - r_sp * carrier_speed
    v_r = r_pr * carrier_speed
    v_o = r_po * carrier_speed + r_o * output_speed

    for i in range(LANE):  # the empty lane costs nothing, and all four fit one register
        speed = lanes[SPIN_SPEED + i]
        spin = lanes[SPIN + i] + half * speed
        # the sun's mesh
        deflection_speed = v_s + r_p * speed
        damped = lanes[DAMPING_SUN + i] * deflection_speed
        elastic = _elastic(d_s + r_p * spin + lanes[RUNOUT_SUN + i], lanes[STIFFNESS_SUN + i], play_s)
        damped = 0.0 if elastic == 0.0 else damped
        force_s = elastic + damped
        lanes[DAMPED_SUN + i] = damped
        arm_1 = lanes[ARM_1_SUN + i]
        arm_2 = lanes[ARM_2_SUN + i]
        both = arm_1 + arm_2
        sliding = arm_1 * sun_speed - both * carrier_speed + arm_2 * speed
        friction_s = _rubbing(lanes[FRICTION_SUN + i] + across_s * sliding, mu_s * math.fabs(force_s))
        on_sun = -r_s * force_s - arm_1 * friction_s
        on_carrier = r_sp * force_s + both * friction_s
        on_planet = -r_p * force_s - arm_2 * friction_s
        lanes[FORCE_SUN + i] = force_s
        lanes[FRICTION_SUN + i] = friction_s
        # the fixed ring's
        deflection_speed = v_r - r_p * speed
        damped = lanes[DAMPING_RING + i] * deflection_speed
        elastic = _elastic(d_r - r_p * spin + lanes[RUNOUT_RING + i], lanes[STIFFNESS_RING + i], play_r)
        damped = 0.0 if elastic == 0.0 else damped
        force_r = elastic + damped
        lanes[DAMPED_RING + i] = damped
        arm_1 = lanes[ARM_1_RING + i]
        both = arm_1 - lanes[ARM_2_RING + i]
        sliding = both * carrier_speed - arm_1 * speed
        friction_r = _rubbing(lanes[FRICTION_RING + i] + across_r * sliding, mu_r * math.fabs(force_r))
        on_carrier -= r_pr * force_r + both * friction_r
        on_planet += r_p * force_r + arm_1 * friction_r
        lanes[FORCE_RING + i] = force_r
        lanes[FRICTION_RING + i] = friction_r
        # the output ring's
        deflection_speed = v_o - r_p2 * speed
        damped = lanes[DAMPING_OUT + i] * deflection_speed
        elastic = _elastic(d_o - r_p2 * spin + lanes[RUNOUT_OUT + i], lanes[STIFFNESS_OUT + i], play_o)
        damped = 0.0 if elastic == 0.0 else damped
        force_o = elastic + damped
        lanes[DAMPED_OUT + i] = damped
        arm_1 = lanes[ARM_1_OUT + i]
        arm_2 = lanes[ARM_2_OUT + i]
        both = arm_1 - arm_2
        sliding = both * carrier_speed - arm_1 * speed + arm_2 * output_speed
        friction_o = _rubbing(lanes[FRICTION_OUT + i] + across_o * sliding, mu_o * math.fabs(force_o))
        on_carrier -= r_po * force_o + both * friction_o
        on_planet += r_p2 * force_o + arm_1 * friction_o
        lanes[FORCE_OUT + i] = force_o
        lanes[FRICTION_OUT + i] = friction_o

        lanes[ON_SUN + i] = on_sun
        lanes[ON_CARRIER + i] = on_carrier
        lanes[ON_OUTPUT + i] = -r_o * force_o - arm_2 * friction_o
        speed += constants.planet_gain * on_planet
        lanes[SPIN_SPEED + i] = speed
        lanes[SPIN + i] = spin + half * speed

    on_carrier = lanes[ON_CARRIER] + lanes[ON_CARRIER + 1] + lanes[ON_CARRIER + 2]
    carrier_speed += constants.carrier_gain * on_carrier
    on_sun = lanes[ON_SUN] + lanes[ON_SUN + 1] + lanes[ON_SUN + 2]
    on_output = lanes[ON_OUTPUT] + lanes[ON_OUTPUT + 1] + lanes[ON_OUTPUT + 2]
    return on_sun, on_output, carrier + half * carrier_speed, carrier_speed

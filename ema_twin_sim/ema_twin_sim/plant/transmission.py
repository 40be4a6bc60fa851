"""One step of the mechanics: rigid, or two inertias with a spring, a damper and a dead zone between them.

Positions are at the fast shaft. A step is drift, kick, drift (position Verlet: second order, conserves the energy of
the contact spring); viscous friction is implicit (speed at the end of the step), dry friction as in ``friction.py``.
"""

from collections import namedtuple

from numba import njit

from .compiled import inlined
from .friction import after_dry_friction

Shafts = namedtuple(
    "Shafts", ["step", "gain", "drag", "output_gain", "output_drag", "stiffness", "damping", "gap", "compliance"]
)
"""Constants of a step of two inertias: its length [s], each one's ``response``, the contact between them."""


@njit(error_model="numpy")
def contact_torque(twist, twist_speed, stiffness, damping, gap, step, compliance):
    """Mean torque [N m] from motor to output in a step that starts at ``twist`` [rad], ``twist_speed`` [rad/s].

    A spring and a damper over a dead zone of +-``gap`` [rad]; a contact with backlash never pulls. The spring is
    evaluated in the middle of the step, the damper at the mean of the speeds before and after (``compliance`` is step /
    2 times the sum of both inverse inertias). A step in which contact begins counts by the share of it in contact: so
    the impulse of an impact does not depend on its time within a step.
    """
    share = 1.0 / (1.0 + damping * compliance)
    middle = twist + 0.5 * step * twist_speed
    if gap == 0.0:
        return (stiffness * middle + damping * twist_speed) * share
    forward = middle > 0.0
    edge = gap if forward else -gap
    depth = twist - edge if forward else edge - twist
    if depth >= 0.0:
        torque = (stiffness * (middle - edge) + damping * twist_speed) * share
    else:
        depth_after = depth + (step * twist_speed if forward else -step * twist_speed)
        if depth_after <= 0.0:
            return 0.0
        touching = depth_after / (depth_after - depth)
        mean = 0.5 * (depth_after if forward else -depth_after)
        torque = touching * (stiffness * mean + damping * twist_speed) * share
    return torque if (torque > 0.0) == forward else 0.0


@njit(error_model="numpy")
def end_stop_torque(angle, speed, lower, upper, stiffness, damping):
    """Torque [N m] of an end stop on the output; angles at the fast shaft, zero between the stops."""
    if angle > upper:
        torque = stiffness * (angle - upper) + damping * speed
        return torque if torque > 0.0 else 0.0
    if angle < lower:
        torque = stiffness * (angle - lower) + damping * speed
        return torque if torque < 0.0 else 0.0
    return 0.0


@njit(error_model="numpy")
def response(step, inertia, viscous):
    """(gain, drag) of one inertia over a step: speed change per N m of torque, and speed factor left by viscosity."""
    gain = step / inertia
    return gain, 1.0 / (1.0 + gain * viscous)


@njit(error_model="numpy")
def shaft_speed(speed, torque, dry, break_away, gain, drag):
    """Speed [rad/s] of one inertia after a step under ``torque`` [N m] and friction (``gain``, ``drag``: response)."""
    share = gain * drag
    return after_dry_friction(speed * drag + share * torque, speed, share * dry, share * break_away)


@njit(error_model="numpy")
def shafts_of(plant, inertia, viscous, step):
    """The ``Shafts`` of a plant whose motor shaft has this ``inertia`` [kg m2] and ``viscous`` friction."""
    gain, drag = response(step, inertia, viscous)
    output_gain, output_drag = response(step, plant.output_inertia, plant.output_viscous)
    compliance = 0.5 * step * (1.0 / plant.motor_inertia + 1.0 / plant.output_inertia)
    return Shafts(
        step,
        gain,
        drag,
        output_gain,
        output_drag,
        plant.contact_stiffness,
        plant.contact_damping,
        plant.gap,
        compliance,
    )


@inlined
def lumped_step(
    shafts, twist, speed, output_speed, torque, load, dry, break_away, output_dry, output_break_away
):  # fmt: skip
    """(speed, output speed [rad/s], transmitted torque [N m]) of two inertias after a step's kick.

    ``twist`` [rad] is that at the start of the step; ``torque`` [N m] drives the motor, ``load`` opposes the output.
    """
    passed = contact_torque(
        twist, speed - output_speed, shafts.stiffness, shafts.damping, shafts.gap, shafts.step, shafts.compliance
    )
    speed = shaft_speed(speed, torque - passed, dry, break_away, shafts.gain, shafts.drag)
    output_speed = shaft_speed(
        output_speed, passed - load, output_dry, output_break_away, shafts.output_gain, shafts.output_drag
    )
    return speed, output_speed, passed


@inlined
def passed_rigidly(plant, acceleration, speed, load):
    """Torque [N m] transmitted by a rigid transmission: that of the output's inertia, friction and ``load``."""
    sense = 1.0 if speed > 0.0 else (-1.0 if speed < 0.0 else 0.0)
    return plant.output_inertia * acceleration + plant.output_viscous * speed + plant.output_dry * sense + load

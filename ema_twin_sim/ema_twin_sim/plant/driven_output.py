"""The output side alone, driven by the motor's measured motion: the torque that a transmission with backlash takes.

The unexplained torque of a two-inertia model needs it: while the gap is open, the motor neither accelerates the output
nor feels its friction. The motor's angle is the integral of its measured speed, slowly pulled to its counter: through a
contact's stiffness, the counter's noise would amount to newton metres. A contact stiffer than the samples resolve would
respond to unmeasured motion between them: it is replaced by a softer, critically damped one, so that the result does
not depend on an assumed stiffness.
"""

import math

from numba import njit

from .drive import lag_gain
from .friction import bristle_share, rubbing
from .time_steps import steps_in
from .transmission import contact_torque, response, shaft_speed

RESOLVED = 2.0 * math.pi * 80.0  # rad/s, the fastest contact that samples of some milliseconds resolve
COUNTER_PULL = 0.08  # s, the lag with which the integrated angle follows the counter: 2 Hz


@njit(error_model="numpy")
def driven_output(plant, state, speed, position, output_torque, interval, step):
    """Mean torque [N m] transmitted to the output over one interval; ``state`` carries the output (``driven_*``).

    ``speed`` [rad/s] and ``position`` [rad] are the motor's at the interval's end, ``output_torque`` [N m] is the load
    of the effects on the output.
    """
    if state.driven_ready == 0.0:
        state.driven_ready = 1.0
        state.driven_motor_angle = position
        state.driven_motor_speed = speed
        state.driven_output_angle = position
        state.driven_output_speed = speed
        return plant.output_viscous * speed + math.copysign(plant.output_dry, speed) + output_torque
    steps = steps_in(interval, step)
    h = interval / steps
    stiffness = plant.contact_stiffness
    damping = plant.contact_damping
    resolved = plant.output_inertia * RESOLVED**2
    if stiffness > resolved:
        stiffness = resolved
        damping = 2.0 * plant.output_inertia * RESOLVED
    start = state.driven_motor_speed
    angle = state.driven_motor_angle
    output_angle = state.driven_output_angle
    output_speed = state.driven_output_speed
    gain, drag = response(h, plant.output_inertia, plant.output_viscous)
    compliance = 0.5 * h / plant.output_inertia
    passed = 0.0
    bristled = plant.bristle_stiffness > 0.0
    share = 1.0 - bristle_share(plant)
    bristle = state.driven_output_bristle
    for k in range(steps):
        motor_speed = start + (speed - start) * ((k + 0.5) / steps)
        torque = contact_torque(
            angle - output_angle,
            motor_speed - output_speed,
            stiffness,
            damping,
            plant.gap,
            h,
            compliance,
        )
        output_angle += 0.5 * h * output_speed
        uneven, bent, dry, held, bristle = rubbing(
            output_speed, torque - output_torque, plant.asymmetry, plant.output_viscous, plant.output_dry,
            plant.output_break_away, bristled, bristle, plant.bristle_stiffness * share, plant.bristle_damping * share,
            h,
        )  # fmt: skip
        load = output_torque + uneven + bent
        output_speed = shaft_speed(
            output_speed,
            torque - load,
            dry,
            held,
            gain,
            drag,
        )
        output_angle += 0.5 * h * output_speed
        angle += h * motor_speed
        passed += torque
    state.driven_motor_angle = angle + lag_gain(interval, COUNTER_PULL) * (position - angle)
    state.driven_motor_speed = speed
    state.driven_output_angle = output_angle
    state.driven_output_speed = output_speed
    state.driven_output_bristle = bristle
    return passed / steps

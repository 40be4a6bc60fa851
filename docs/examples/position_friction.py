"""Position friction: a dry level torque * (1 + sin(count * theta_o + phase)) / 2 [N m] that varies along the output.

An effect of one's own, in one file: copy it, change it, and name it wherever a model with it is read:

    ema-twin effects position_friction --with docs/examples/position_friction.py
    ema-twin add docs/examples/position_friction.py --set torque=0.1 --model polito_bench -o mine.yaml
    ema-twin compare recordings --model polito_bench --model mine.yaml --with docs/examples/position_friction.py

A rack, a screw or a bearing that is tight in places: friction swings between zero and ``torque`` as the output turns,
``count`` times per turn, whatever the direction and the speed.
"""

import math

from ema_twin_sim.effects.effect import DRY_LEVEL, Effect, Parameter

_COUNTS = tuple(range(2, 100, 3))
"""Where a search for count begins: over a travel of 1 rad, one of these is near enough to lead to the right one."""


def act(at, p):
    """What the effect does at one moment: here a dry friction level [N m], at the fast (motor) shaft.

    A positive torque opposes positive motion, on the motor (TORQUE) and on the load (OUTPUT_TORQUE) alike: a spring
    that returns the output to zero is ``+p[0] * at.output_angle``.

    It is compiled to machine code and called at every step (25 us), so it holds numbers, ``math`` and ``numpy`` only;
    a function that it calls needs ``@numba.njit(error_model="numpy")`` above it.

    ``p`` holds the parameters in the order of the table below: p[0] is torque, p[1] count, p[2] phase. ``at`` is where
    the machine stands:

        at.time                 s since the recording's first sample
        at.motor_angle          rad, at.motor_speed rad/s, at.acceleration rad/s2: of the fast shaft
        at.electrical_angle     rad, pole pairs times motor_angle; say electrical=True below where you use it
        at.output_angle         rad of the slow shaft as its encoder counts, the same place in every recording
        at.output_travel        rad of the slow shaft since the recording's first sample
        at.output_speed         rad/s of the slow shaft
        at.current              A, at.motor_torque N m
        at.transmitted_torque   N m at the fast shaft, passed on to the output
        at.dry_level            N m, of the motor's side; at.viscous_coefficient N m s/rad: the model's friction so far
    """
    return p[0] * 0.5 * (1.0 + math.sin(p[1] * at.output_angle + p[2]))


EFFECT = Effect(
    id="position_friction",  # its name in models, commands and ROS parameters
    summary="dry friction that varies with the output's position: a tight spot, a worn stretch",
    equation="L = torque · (1 + sin(count·θ_o + phase)) / 2",
    depends_on="output_position",  # what it shows over: where something unknown does too, the two are not told apart
    signature="current error against the motion that depends on the output's position, not on speed",
    source="a user's own; compare Armstrong-Hélouvry, Dupont, Canudas de Wit 1994 on position-dependent friction",
    # name, unit, typical value, least, greatest, meaning; the first one is the effect's size
    parameters=(
        Parameter("torque", "N m", 0.05, 0.0, 100.0, "level at the tightest place, fast shaft"),
        Parameter("count", "1", 10.0, 1.0, 100.0, "tight places per turn of the output", starts=_COUNTS),
        Parameter("phase", "rad", 0.0, -6.284, 6.284, "phase at the output encoder's zero", periodic=True),
    ),
    act=act,
    place=DRY_LEVEL,  # friction, which holds still at rest; TORQUE on the motor, OUTPUT_TORQUE on the load: forces
)

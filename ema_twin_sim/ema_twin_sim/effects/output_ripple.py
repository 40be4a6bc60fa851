"""Output ripple: T = torque * sin(order * theta_o + phase) [N m], with `order` cycles per turn of the output.

Causes: a bent joint (twice per turn), the teeth of the last gear, the rollers of an output bearing. Once per turn is
gravity.
"""

import math

from .effect import OUTPUT_TORQUE, Effect, Parameter, Trait


def act(at, p):
    """Torque [N m] at the fast shaft, from the output encoder's own angle."""
    return p[0] * math.sin(p[2] * at.output_angle + p[1])


EFFECT = Effect(
    id="output_ripple",
    summary="torque that repeats with the output's turns: a joint, the last gear, a bearing",
    equation="T = torque · sin(order·θ_o + phase)",
    depends_on="output_position",
    signature="current error that repeats a whole number of times in a turn of the output, the same in both directions",
    shown_by="travel over a large part of an output turn",
    source="kinematics of what turns with the output; twice: a universal joint",
    parameters=(
        Parameter("torque", "N m", 0.03, 0.0, math.inf, "amplitude, reduced to the fast shaft"),
        Parameter("phase", "rad", 0.0, -6.284, 6.284, "phase at the output encoder's zero", periodic=True),
    ),
    options={"order": ("2",)},
    free_option="order",
    option_value=lambda options: float(options["order"]),
    act=act,
    place=OUTPUT_TORQUE,
    searched=False,
    traits=(Trait.OUTPUT_WAVE, Trait.OF_OUTPUT_TURNS),
)

"""Encoder delay: the output encoder shows theta_o(t - delay), delay in s; so does the drive's position loop.

An encoder on a bus is late by a cycle or more. A time lag between two encoders looks like backlash and compliance.
"""

import math

from .effect import Effect, Implausible, Parameter, Trait


def settle(plant, parameters, options):
    """Delay the output encoder."""
    plant["encoder_delay"] += parameters["delay"]


EFFECT = Effect(
    id="encoder_delay",
    summary="an output encoder that answers late",
    equation="the encoder shows θ_o(t − delay)",
    depends_on="encoders",
    signature="output position error in proportion to speed; nothing in the current",
    shown_by="fast motion, with the output encoder recorded",
    source="Weigand et al., robot identification data, 2.8 to 3.0 ms between two encoders",
    parameters=(Parameter("delay", "s", 0.003, 0.0, math.inf, "time by which it is late"),),
    settle=settle,
    repeatable=False,
    delays=True,
    traits=(Trait.SENSOR_DELAY, Trait.TRANSIENT),
    implausible=(
        Implausible(
            "delay",
            lambda v, c: v["delay"] > 8.0 * c.sample_period,
            "an encoder answers within a few samples: is it compliance or play?",
        ),
    ),
)

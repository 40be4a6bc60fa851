"""Encoder eccentricity: the encoder shows theta_o + a (sin(n theta_o + phase) - sin(n theta_o(0) + phase)) [rad].

An eccentric encoder disc has an error once per turn (order n = 1); an oval one, or a resolver whose two windings
differ, twice; a resolver with several pole pairs, once per pole pair. theta_o is the encoder's own angle; positions are
published from zero. An error of the motor's encoder has orders of n times the gear ratio. Hanselman,
"Resolver signal requirements for high accuracy resolver-to-digital conversion" (1990).
"""

from ..plant.layout import ANGLE_ERRORS
from .effect import Effect, Implausible, Parameter, Trait


def settle(plant, parameters, options):
    """Add a wave to the output encoder's error."""
    if plant["angle_errors"] < ANGLE_ERRORS:  # one too many is refused after all effects were applied
        row = plant["angle_error"][plant["angle_errors"]]
        row[:] = parameters["amplitude"], parameters["phase"], float(options["order"])
    plant["angle_errors"] += 1


EFFECT = Effect(
    id="encoder_eccentricity",
    summary="an output encoder off its shaft's centre, or a resolver's angle error",
    equation="the encoder shows θ_o + amplitude · (sin(order·θ_o + phase) − sin(order·θ_o(0) + phase))",
    depends_on="encoders",
    signature="output position error that follows the sine of the output's angle; nothing in the current",
    shown_by="travel over a large part of an output turn, with the output encoder recorded",
    source="geometry of an eccentric disc; Hanselman 1990 for resolvers",
    parameters=(
        Parameter("amplitude", "rad", 0.0005, 0.0, 0.1, "amplitude, slow shaft"),
        Parameter("phase", "rad", 0.0, -6.284, 6.284, "phase at the encoder's zero", periodic=True),
    ),
    options={"order": ("1", "2")},
    free_option="order",
    settle=settle,
    traits=(Trait.SENSOR_WAVE, Trait.OF_OUTPUT_TURNS),
    implausible=(
        Implausible(
            "amplitude",
            lambda v, c: v["amplitude"] > 0.02,
            "an encoder that far off its centre would be seen to wobble: is it gravity on a soft shaft?",
        ),
    ),
)

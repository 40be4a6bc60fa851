"""Encoder eccentricity: the encoder shows theta_o + amplitude (sin(theta_o + phase) - sin(theta_o(0) + phase)) [rad].

An encoder disc whose centre is off its shaft. theta_o is the encoder's own angle; positions are published from zero.
"""

from .effect import Effect, Parameter


def settle(plant, parameters, options):
    """Set the output encoder off its shaft."""
    plant["eccentricity_amplitude"] = parameters["amplitude"]
    plant["eccentricity_phase"] = parameters["phase"]


EFFECT = Effect(
    id="encoder_eccentricity",
    summary="an output encoder off its shaft's centre",
    equation="the encoder shows θ_o + amplitude · (sin(θ_o + phase) − sin(θ_o(0) + phase))",
    depends_on="encoders",
    signature="output position error that follows the sine of the output's angle; nothing in the current",
    source="geometry of an eccentric disc",
    parameters=(
        Parameter("amplitude", "rad", 0.0005, 0.0, 0.1, "amplitude, slow shaft"),
        Parameter("phase", "rad", 0.0, -6.284, 6.284, "phase at the encoder's zero", periodic=True),
    ),
    settle=settle,
    repeatable=False,
)

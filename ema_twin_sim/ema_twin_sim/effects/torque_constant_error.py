"""Torque constant error: the machine has scale * Kt per ampere, T = (1 - scale) Kt i [N m]; the drive assumes Kt.

Magnets lose strength with heat and age; nominal torque constants are accurate to some per cent.
"""

from .effect import Effect, Implausible, Parameter, Trait


def settle(plant, parameters, options):
    """Scale the machine's torque constant; the drive's stays nominal."""
    plant["torque_constant"] *= parameters["scale"]


def settle_winding(winding, parameters, options):
    """Scale the flux of the magnets."""
    winding["magnet_strength"] *= parameters["scale"]


EFFECT = Effect(
    id="torque_constant_error",
    summary="a motor that gives more or less torque per ampere than its drive believes",
    equation="T = (1 − scale) · Kt · i",
    depends_on="current",
    signature="all torques seem scaled: friction, load and inertia by the same factor",
    shown_by="hard acceleration of a known inertia",
    source="Krishnan, Permanent Magnet Synchronous and Brushless DC Motor Drives, 2010",
    parameters=(Parameter("scale", "1", 0.9, 0.5, 1.5, "true over nominal torque constant", neutral=1.0),),
    settle=settle,
    settle_winding=settle_winding,
    repeatable=False,
    traits=(Trait.TORQUE_FACTOR, Trait.LIKE_PLAY_OR_SPRING, Trait.BY_CURRENT),
    told_by="an inertia that is known better, or the voltage, would tell the torque constant",
    implausible=(
        Implausible(
            "scale",
            lambda v, c: not 0.7 < v["scale"] < 1.3,
            "magnets lose some per cent, not a third: are inertia and friction of the model right?",
        ),
    ),
)

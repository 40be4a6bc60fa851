"""Asymmetric friction: fraction * (L + b |w|) [N m]; friction is (1 + fraction) forward and (1 - fraction) backward.

L [N m] and b [N m s/rad] are the total dry level and viscous coefficient of the motor side: the effect scales the sum
of all other effects. (A Coulomb level alone that differs by direction is a constant load while sliding.)
"""

from .effect import Effect, Implausible, Parameter, Trait


def settle(plant, parameters, options):
    """Add to the plant's asymmetry, which is applied last."""
    plant["asymmetry"] += parameters["fraction"]


EFFECT = Effect(
    id="asymmetric_friction",
    summary="more friction in one direction than in the other",
    equation="T = fraction · (L + b·|ω|)",
    depends_on="direction",
    signature="current error that is even in speed: it grows with |ω| and does not flip with direction",
    shown_by="motion in both directions",
    source="Armstrong-Hélouvry, Dupont, Canudas de Wit 1994",
    parameters=(Parameter("fraction", "1", 0.15, -0.9, 0.9, "excess forward, lack backward"),),
    settle=settle,
    traits=(Trait.SHOWN_BY_REVERSALS,),
    implausible=(
        Implausible(
            "fraction",
            lambda v, c: abs(v["fraction"]) > 0.6,
            "friction four times as large one way as the other: is it a constant load?",
        ),
    ),
)

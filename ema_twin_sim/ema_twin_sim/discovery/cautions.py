"""Warnings that accompany a finding."""

from ..criteria import SMALL


def of_open_constants() -> str:
    """Warning for a model with open constants: what an effect must achieve to be named, and why."""
    return (
        "your model has unknown constants, and fitting them can hide a missing effect. An effect is named only if less "
        f"than {100.0 * SMALL:.0f} % of the drive's torque remains unexplained; constants from a data sheet help"
    )


ALONE = ("with one recording the result is not validated on unseen data; give several",)
ONE_DIRECTION = (
    "nothing reverses here: in one direction a constant load, asymmetric friction and dry friction are the same "
    "torque, so the one that is named may be one of the others; record a motion in both directions",
)
WITHOUT_TORQUE = (
    "no current and no torque was recorded: play, delays and angles are absolute; torques, stiffnesses and dampings "
    "scale with the inertia in the model file, and are wrong by the same factor as it is",
)
"""Warning for recordings with both encoders but no torque or current."""

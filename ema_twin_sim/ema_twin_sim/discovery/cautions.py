"""Warnings that accompany a finding."""

from ..criteria import SMALL


def of_open_constants() -> str:
    """Warning for a model with open constants: what an effect must achieve to be named, and why."""
    return (
        "your model leaves constants open, and free numbers can hide what is missing: an effect is named only where "
        f"less than {100.0 * SMALL:.0f} % of the drive's torque (rms) is left without a cause, which may still be "
        "several times the sensors' noise; constants from a data sheet or an own measurement make the answer sharper"
    )


ALONE = ("with one recording the result is not validated on unseen data; give several",)
ONE_DIRECTION = (
    "no recording reverses: in one direction a constant load, friction that differs by direction and dry friction are "
    "one and the same torque, and whichever is told may be another of them; record a motion there and back",
)
WITHOUT_TORQUE = (
    "no current and no torque was recorded: play, delays and angles are told as they are; torques, stiffnesses and "
    "dampings hold beside the inertia that the model file has, and are as far off as that is",
)
"""Warning for recordings with both encoders but no torque or current."""

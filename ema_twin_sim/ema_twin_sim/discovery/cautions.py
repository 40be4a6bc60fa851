"""Cautions that come with a finding, in words."""

from ..criteria import SMALL


def of_open_constants() -> str:
    """What is asked of an effect in a model whose constants are open, and why."""
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
"""What to say where both encoders were recorded, and nothing else."""

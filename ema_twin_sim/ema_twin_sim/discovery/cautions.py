"""Cautions that come with a finding, in words."""

OPEN_CONSTANTS = (
    "the model has unknown constants, so an effect counts only if almost no torque error remains; that may still be "
    "more than the sensors' noise",
)
ALONE = ("with one recording the result is not validated on unseen data; give several",)
WITHOUT_TORQUE = (
    "no current and no torque was recorded: play, delays and angles are told as they are; torques, stiffnesses and "
    "dampings hold beside the inertia that the model file has, and are as far off as that is",
)
"""What to say where both encoders were recorded, and nothing else."""

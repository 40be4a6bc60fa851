"""Cautions that come with a finding, in words."""

OPEN_CONSTANTS = (
    "constants of this model are open: effects count as found where hardly anything is left of the torque, and what is "
    "left is not held against the sensors' noise",
)
ALONE = ("one recording: what it is judged by was fitted to; give several",)
WITHOUT_TORQUE = (
    "no current and no torque was recorded: play, delays and angles are told as they are; torques, stiffnesses and "
    "dampings hold beside the inertia that the model file has, and are as far off as that is",
)
"""What to say where both encoders were recorded, and nothing else."""

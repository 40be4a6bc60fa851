"""Cautions that come with a finding, in words."""

OPEN_CONSTANTS = (
    "constants of this model are open: effects count as found where hardly anything is left of the torque, and what is "
    "left is not held against the sensors' noise",
)
ALONE = ("one recording: what it is judged by was fitted to; give several",)

"""Warnings that accompany a finding."""

from ..criteria import SMALL


def of_open_constants() -> str:
    """Warning for a model with open constants: what an effect must achieve to be named, and why."""
    return (
        "your model has unknown constants, and fitting them can hide a missing effect: an effect is named only if less "
        f"than {100.0 * SMALL:.0f} % of the drive's torque (rms) remains unexplained beyond the sensors' noise in the "
        "rows that are judged (averages of neighbouring samples in which the machine slides, or operating points); in "
        "single samples (the RMSE after the last step) more may remain, and either may be several times the sensors' "
        "noise; constants from a data sheet or a measurement of your own make the answer sharper"
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

"""Warnings that accompany a finding."""

import numpy as np

from ..criteria import NEARLY_ALL, SMALL
from ..effects import Trait, effects_with
from ..identification.equation import EquationErrorProblem
from ..identification.fit import Fit
from ..plant.measured_motion import OUTPUT_ANGLE
from ..plant.sensors import angle_error


def of_open_constants() -> str:
    """Warning for a model with open constants: what an effect must achieve to be named, and why."""
    return (
        "your model has unknown constants, and fitting them can hide a missing effect: an effect is named only if less "
        f"than {100.0 * SMALL:.0f} % of the drive's torque (rms) remains unexplained in the rows that are judged "
        "(averages of neighbouring samples in which the machine slides, or operating points); in single samples (the "
        "RMSE after the last step) more may remain, and either may be several times the sensors' noise; constants from "
        "a data sheet or a measurement of your own make the answer sharper"
    )


def of_straight_waves(problem: EquationErrorProblem, f: Fit) -> tuple[str, ...]:
    """Warning if the encoder's waves that were found are together a straight line over the way of the recordings.

    A wrong gear ratio, or a wrong scale of one encoder, lets the encoders differ by such a line; over less than a turn
    a wave does so too.
    """
    h = f.hypothesis
    if effects_with(Trait.SENSOR_WAVE).isdisjoint(h.effects):
        return ()
    plant = f.predicted.plant[0]
    ways, errors = [], []
    for o in problem.observations:
        angle = o.motion[o.encoder_rows, OUTPUT_ANGLE]
        error = angle_error(plant, o.output_origin, angle)
        if len(angle):
            ways.append(angle - angle.mean())
            errors.append(error - error.mean())
    way, error = np.concatenate(ways), np.concatenate(errors)
    slope = float(way @ error) / max(float(way @ way), 1e-300)
    left = error - slope * way
    if not float(left @ left) < (1.0 - NEARLY_ALL) * float(error @ error):
        return ()
    ratio = h.base.value("machine.gear_ratio")
    return (
        "over the way of these recordings the encoder's error is a straight line: a gear ratio of "
        f"{ratio / (1.0 + slope):.6g} instead of {ratio:.6g} does the same, or an encoder whose scale is off by "
        f"{100.0 * abs(slope):.2g} %; check these first, and record more than a turn of the output",
    )


ALONE = ("with one recording the result is not validated on unseen data; give several",)
ONE_DIRECTION = (
    "no recording reverses: in one direction a constant load, asymmetric friction and dry friction are the same "
    "torque, so the one that is named may be one of the others; record a motion in both directions",
)
WITHOUT_TORQUE = (
    "no current and no torque was recorded: play, delays and angles are absolute; torques, stiffnesses and dampings "
    "scale with the inertia in the model file, and are wrong by the same factor as it is",
)
"""Warning for recordings with both encoders but no torque or current."""

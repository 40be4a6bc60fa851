"""Straight waves: an encoder error that was found and is a straight line, as a wrong gear ratio would leave."""

from __future__ import annotations

import numpy as np

from ..criteria import NEARLY_ALL
from ..effects import Trait, effects_with
from ..identification.equation import EquationErrorProblem
from ..identification.fit import Fit
from ..plant.motion import OUTPUT_ANGLE
from ..plant.sensors import angle_error


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

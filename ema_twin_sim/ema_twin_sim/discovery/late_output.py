"""An output encoder later than a search looks for: what it leaves between the encoders goes with the speed.

A search that searched this far from the start would take wide play for one.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from ..criteria import NEARLY_ALL
from ..effects import effects_with
from ..effects.trait import Trait
from ..identification.equation import EquationErrorProblem
from ..identification.fit import Fit
from ..plant.motion import SPEED

SEARCHED_TO = 2.0  # times the delay that the speeds tell


def longer_delay(problem: EquationErrorProblem, f: Fit, excluded: Collection[str]) -> float | None:
    """How far to search for a delay of the encoder [own s] if a fit leaves a longer one.

    None if it leaves none, or if a delay is in the model or ``excluded`` from the search.
    """
    if effects_with(Trait.SENSOR_DELAY) <= {*excluded, *f.hypothesis.held}:
        return None
    longest = SEARCHED_TO * _delay(problem, f)
    return longest if longest > problem.reached.latest else None


def _delay(problem: EquationErrorProblem, f: Fit) -> float:
    """By how much [own s] the output is late, if the error of the encoder difference is in proportion to the speed.

    NaN if it is not, for more than a small part of its power.
    """
    ratio = f.hypothesis.base.value("machine.gear_ratio")
    errors, speeds = [np.empty(0)], [np.empty(0)]
    for o, part in zip(problem.observations, problem.encoder_parts, strict=True):
        error = (problem.measured - f.predicted.rows)[part] * o.encoder_noise
        speed = o.motion[o.encoder_rows, SPEED] / ratio
        for piece in np.unique(o.encoder_piece):  # each has its own offset
            of = o.encoder_piece == piece
            errors.append(error[of] - error[of].mean())
            speeds.append(speed[of] - speed[of].mean())
    error, speed = (np.concatenate(parts) for parts in (errors, speeds))
    slope = float(error @ speed) / max(float(speed @ speed), 1e-300)
    left = error - slope * speed
    return -slope if float(left @ left) < (1.0 - NEARLY_ALL) * float(error @ error) else np.nan

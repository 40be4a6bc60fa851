"""An error of the output's position that grows with the speed: a shift in time between setpoint and motion."""

from __future__ import annotations

import numpy as np

from ..criteria import MOSTLY
from ..model import Model
from ..quantities import quantity
from .content import Shown

_ALIKE = 0.5  # of the output's error: what the encoders may differ by and still show the same


def lag_sentence(given: Shown, model: Model, place: int) -> str:
    """What an error of the output's position in proportion to its speed most likely is, and why no effect is named.

    ``place`` is that of the ``model`` among those compared. Empty if the setpoint drives no twin, if another dependence
    explains more, or if the encoders show different errors: then it is an encoder's.
    """
    errors = given.comparisons[place].overall
    if given.comparisons[place].input != "setpoint" or not {"output_position", "motor_position"} <= {*errors}:
        return ""
    ratio = model.value("machine.gear_ratio")
    output, motor = errors["output_position"]["rmse"], errors["motor_position"]["rmse"] / ratio
    parts = [each.stretches["output_position"] for each in given.curves[place] if "output_position" in each.stretches]
    if not parts or abs(motor - output) > _ALIKE * output:
        return ""
    residual, speed = (np.concatenate([getattr(part, of) for part in parts]) for of in ("residual", "speed"))
    known = np.isfinite(residual) & np.isfinite(speed)
    residual, speed = residual[known], speed[known] / ratio
    moved, power = float(speed @ speed), float(residual @ residual)
    if not moved > 0.0 or not power > 0.0:
        return ""
    shift = float(speed @ residual) / moved
    if shift**2 * moved < MOSTLY * power:
        return ""
    samples = abs(shift) / given.recordings[0].sample_period
    when = "earlier" if shift > 0.0 else "later"
    return (
        f"It grows in proportion to the speed, and both encoders show it: most likely the machine follows its setpoint "
        f"{quantity(abs(shift), 's', 2)} ({samples:.1f} of a sample) {when} than the twin, such as by when in a cycle "
        "the drive reads and traces its signals. Such a shift changes neither the torque that a motion needs nor the "
        "difference between the encoders, by which effects are judged, so none is named for it."
    )

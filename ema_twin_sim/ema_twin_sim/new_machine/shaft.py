"""Of which shaft a motor's position is given: guessed from how far it goes where the motor's speed is known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ema_bench_replay.recording import Recording

from ..measured.consistency import is_usual_mistake, way_by_speed
from ..measured.smoothing import gaussian, smooth

OWN = 0.1  # of one, within which a position goes the way of the motor's speed
ALIKE = 0.02  # of a gear ratio of one: both shafts turn alike
SAME_RATIO = 0.1  # relative, within which a way is that of the gear ratio that was given
NEAR_A_WHOLE = 0.05  # of a turn
ANGLE_ERROR = 1e-3  # rad, of an encoder over the travel of a recording
EXACT = 2e-4  # relative, within which a ratio is the whole number beyond doubt
_FEWEST_TO_REFINE = 400  # samples
_SMOOTHED = 10.0  # samples
_AT_ENDS = 40  # samples that this smoothing bends at either end
_MOVING = 0.3  # of the furthest way
_FEWEST = 10
_WINDOW = 0.1  # of a recording's samples: the way over which shafts are compared


@dataclass(frozen=True)
class Shaft:
    """Whose turns a motor's position counts, ``motor`` or ``output``; the gear ratio that shows, and what to look at.

    ``ratio`` is None where the recording shows none. An empty ``doubt`` leaves none.
    """

    name: str = "motor"
    ratio: float | None = None
    doubt: str = ""


def position_shaft(recording: Recording, gear_ratio: float | None, *, units_known: bool) -> Shaft:
    """The shaft of a recording's motor position, read as the motor's; ``gear_ratio`` is the one given, if any."""
    if recording.motion != "rotary" or recording.of_points:
        return Shaft()
    between = ratio_of_positions(recording)
    alike = between is not None and abs(between - 1.0) < ALIKE
    times = way_by_speed(recording) if units_known else None
    if times is None:
        if alike and gear_ratio is not None and abs(gear_ratio - 1.0) > OWN:
            return Shaft("output", gear_ratio, "it turns as the output does: taken for the output's angle")
        return Shaft()
    if abs(abs(times) - 1.0) < OWN:
        return Shaft()
    told = f"it goes {abs(times):.4g} times the way that the speed makes"
    ratio = 1.0 / abs(times)
    if gear_ratio is not None and abs(ratio / gear_ratio - 1.0) > SAME_RATIO:
        return Shaft(doubt=f"{told}, where 1 or one over the gear ratio was to be expected; are the units right?")
    if gear_ratio is None and not alike and (ratio < 1.0 or is_usual_mistake(times)):
        return Shaft(doubt=f"{told}; are the units of both right?")
    return Shaft("output", gear_ratio or ratio, f"{told}: taken for the output's angle")


def ratio_of_positions(recording: Recording) -> float | None:
    """The gear ratio that both positions show, negative where they turn against each other; None where they do not."""
    if not recording.has("motor_position", "output_position"):
        return None
    lag = max(1, int(_WINDOW * len(recording)))
    motor, output = (
        recording.signals[name][lag:] - recording.signals[name][:-lag] for name in ("motor_position", "output_position")
    )
    both = np.isfinite(motor) & np.isfinite(output) & (output != 0.0)
    far = both & (np.abs(motor) > _MOVING * np.abs(motor[both]).max(initial=0.0))
    if far.sum() < _FEWEST:
        return None
    ratio = float(np.median(motor[far] / output[far]))
    if recording.of_points or len(recording) < _FEWEST_TO_REFINE:
        return ratio
    refined = _beside_lags(recording)
    return refined if abs(refined / ratio - 1.0) < ALIKE else ratio


def _beside_lags(recording: Recording) -> float:
    """The ratio of both positions where the output may be late, lie on either side of its play, or wind up."""
    motor, output = (recording.signals[name] for name in ("motor_position", "output_position"))
    step, bend = (smooth(motor, gaussian(_SMOOTHED, 1.0, order)) for order in (1, 2))
    columns = np.stack([output, step, np.sign(step), bend, np.ones(len(step))], axis=1)
    columns[:_AT_ENDS] = columns[-_AT_ENDS:] = np.nan
    whole = np.isfinite(columns).all(axis=1) & np.isfinite(motor)
    return float(np.linalg.lstsq(columns[whole], motor[whole], rcond=None)[0][0])


def whole_ratio(ratio: float, recording: Recording) -> float | None:
    """The whole number that an encoder's angle error may have bent a ratio from; None where none is so near."""
    nearest = float(round(ratio))
    if abs(nearest) < 2.0 or abs(ratio - nearest) > NEAR_A_WHOLE:
        return None
    travel = float(np.ptp(recording.signals["output_position"][np.isfinite(recording.signals["output_position"])]))
    return nearest if abs(ratio / nearest - 1.0) * travel < ANGLE_ERROR else None

"""The wavelength by default: one turn of the motor, as far as its place along the judged position is known."""

from __future__ import annotations

import math

import numpy as np

from ema_bench_replay.recording import AT, Recording

from ..criteria import PART, SMALL
from ..health.motion_record import SPEED, MotionRecord
from ..measured.ratio_of_positions import ratio_of_positions
from ..model import Model

_UNKNOWN = "no wave that repeats with the position is judged, because {}; give the wavelength with --wavelength{}"


def turn_of_motor(record: MotionRecord, model: Model | None, recording: Recording) -> tuple[float, str]:
    """One turn of the motor in the position's unit [rad], and a warning; NaN and why if it is unknown.

    All recordings of a unit need the very same wavelength, so of a ratio that both encoders show its whole number is
    taken. It need not be exact: it is near enough if waves do not part over the travel.
    """
    if record.place == SPEED:
        return math.nan, f"{recording.name}: has no position; its speed is integrated instead, so no wave is judged"
    if recording.motion == "linear":
        return math.nan, ""
    turn = 2.0 * math.pi
    if record.place == "motor_position" and recording.metadata.get(f"{record.place}{AT}") != "output":
        return turn, ""
    if model is not None:
        return turn / abs(model.value("machine.gear_ratio")), ""
    ratio = ratio_of_positions(recording)
    if ratio is None:
        return math.nan, _UNKNOWN.format("the output's angle alone does not show a turn of the motor", " or --model")
    whole = max(1.0, float(round(abs(ratio))))
    off = abs(abs(ratio) - whole)
    if off < PART and off * float(np.ptp(record.position)) < SMALL * turn:
        return turn / whole, ""
    shown = f"the gear ratio that both encoders show, {abs(ratio):.4g}, is no whole number"
    return math.nan, _UNKNOWN.format(shown, f" {turn / abs(ratio):.4g} if it is a turn of the motor")

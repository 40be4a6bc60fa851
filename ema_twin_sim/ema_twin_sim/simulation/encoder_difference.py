"""The difference between both encoders, measured and of a model, where the measured current drives the twin.

That twin's positions drift away from the machine's, and with them the difference, which shows backlash, a compliant
shaft, a late encoder and errors of its angle. So the model's output is driven by the motor's measured motion instead.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ema_bench_replay.long_columns import is_long
from ema_bench_replay.recording import Recording

from ..model import Model
from .behind_motor import twin_behind_motor
from .compared_signals import ENCODER_DIFFERENCE

Signals = Mapping[str, np.ndarray]

_AT_ONCE = 4  # times the memory of a twin: a recording is too long sooner by this


def with_encoder_difference(
    model: Model, recording: Recording, source: str, twin: Recording
) -> tuple[Signals, Signals]:
    """The signals (n,) of a recording and of its twin, which ``source`` drives, with the encoder difference [rad].

    As they are if that is not the current, if a position is missing, if the recording is too long for the memory, or if
    the model's gear train is simulated tooth by tooth, which ``behind_motor`` does not.
    """
    toothed = model.kinds["transmission"] == "planetary"
    if source != "current" or toothed or not holds_both_encoders(recording):
        return recording.signals, twin.signals
    motor = recording.signals["motor_position"] / model.value("machine.gear_ratio")
    pair = (recording.signals["output_position"], twin_behind_motor(model, recording).signals["output_position"])
    measured, its = (output - motor for output in pair)
    mean = np.nanmean(measured)
    return (
        {**recording.signals, ENCODER_DIFFERENCE: measured - mean},
        {**twin.signals, ENCODER_DIFFERENCE: its - mean},
    )


def too_long(samples: int) -> bool:
    """Whether a recording of so many samples is compared without the encoder difference."""
    return is_long(_AT_ONCE * samples)


def holds_both_encoders(recording: Recording) -> bool:
    """Whether some sample of a recording that fits into memory holds both positions."""
    positions = ("motor_position", "output_position")
    if recording.of_points or too_long(len(recording)) or not recording.has(*positions):
        return False
    return bool(np.isfinite(sum(recording.signals[name] for name in positions)).any())

"""A warning about findings that scale with a torque constant that nobody measured."""

from __future__ import annotations

from collections.abc import Sequence

from ema_bench_replay.recording import Recording

from ..model import Model
from ..model.check_comment import is_assumed
from ..model.model_file import TORQUE_CONSTANT
from ..quantities import quantity


def of_assumed_torque(recordings: Sequence[Recording], model: Model) -> tuple[str, ...]:
    """Warning for a ``model``, as given, whose torque per ampere nobody measured; empty without a recorded current."""
    held = model.constants.get(TORQUE_CONSTANT)
    if held is None or not is_assumed(held.source) or not any(recording.has("current") for recording in recordings):
        return ()
    if any(recording.has("load_torque") for recording in recordings):  # the recordings tell the constant
        return ()
    return (
        f"the torque constant of your model, {quantity(held.value, model.unit(TORQUE_CONSTANT))}, is only assumed: all "
        "torques, inertias and dampings that were found are wrong by the same factor as it is; take it from the "
        "motor's data sheet, correct its value and its source in the model file, and search again",
    )

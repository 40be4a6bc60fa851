"""A sentence on the numbers of a model that nobody has found yet."""

from __future__ import annotations

from collections.abc import Sequence

from ema_bench_replay.recording import Recording

from ..listing import listed
from ..model import Model
from ..model.check_comment import START_VALUE
from .sentences import effect_words


def open_values_sentence(model: Model, recordings: Sequence[Recording]) -> str:
    """Which numbers of a draft are still start values, and what finds them; empty if there are none.

    Without a torque, as of two encoders alone, nothing finds them, and what is compared hardly depends on them.
    """
    constants = [path for path, held in model.constants.items() if held.source == START_VALUE]
    if not constants:
        return ""
    names = [model.shown_path(path).partition(".")[2].replace("_", " ") for path in constants]
    effects = [effect_words(name) for name, instance in model.active.items() if instance.open]
    still = f"Model {model.name}: {listed([*names, *effects])} are still start values"
    if not any(recording.has(name) for recording in recordings for name in ("current", "motor_torque")):
        return (
            f"{still}: no current or torque was recorded, without which neither discover nor fit can find them. "
            "Record the current as well to find them."
        )
    return f"{still}, so its errors say nothing of the machine. Run discover or fit first: both find these numbers."

"""Split a single table of operating points into two recordings, so that each can be judged by the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording

from ..model import Model
from ..simulation.behind_motor import of_encoders_alone
from ..simulation.operating_points import FEWEST, directed

FEWEST_OF_BOTH = 4 * FEWEST
BLOCKS = 8  # of the positions; every other block is judged by the rest

#: Key of a half's metadata: the name of the whole.
HALF_OF = "half_of"


def operating_point_folds(recordings: Sequence[Recording], model: Model) -> list[Recording]:
    """Split a single recording of operating points in two, so that each can be judged by the other.

    Every other eighth of its positions goes to one half; if it has only one position, every other point. Other
    recordings, and those with few points, are returned unchanged. They are in the units of the ``model``, whose sensors
    say which points are at rest.
    """
    refuse_mixed(recordings)
    if len(recordings) != 1 or not recordings[0].of_points or len(recordings[0]) < FEWEST_OF_BOTH:
        return list(recordings)
    # in a part, the direction of approach to a point is no longer visible
    whole = directed(recordings[0], model.value("sensors.speed_noise"))
    position = whole.signals.get("motor_position")
    rank = np.arange(len(whole))
    if position is not None and np.nanmax(position) > np.nanmin(position):
        rank[np.argsort(position, kind="stable")] = np.arange(len(whole))
        odd = (rank * BLOCKS // len(whole)) % 2 == 0
        names = [f"eighths {' '.join(map(str, range(first, BLOCKS + 1, 2)))} of its positions" for first in (1, 2)]
    else:
        odd = rank % 2 == 0
        names = [f"every other point from the {first} on" for first in ("first", "second")]
    first, second = (_part(whole, chosen, name) for chosen, name in zip((odd, ~odd), names, strict=True))
    return [first, replace(second, warnings=())]  # what is wrong with the whole is told once


def _part(whole: Recording, chosen: np.ndarray, name: str) -> Recording:
    stamps = whole.stamps[chosen]
    return replace(
        whole,
        name=f"{whole.name}, {name}",
        stamps=stamps - stamps[0],
        signals={key: values[chosen] for key, values in whole.signals.items()},
        start=whole.start + int(stamps[0]),
        metadata={**whole.metadata, HALF_OF: whole.name},
    )


def refuse_mixed(recordings: Sequence[Recording]) -> None:
    """Raise InputError if recordings of different kinds are given together, since they are judged differently.

    The kinds are operating points, two encoders without torque data, and all others.
    """
    names = [recording.name for recording in recordings if recording.of_points]
    if names and len(names) < len(recordings):
        raise InputError(
            f"{', '.join(names)}: operating points, beside recordings of a motion; give one kind at a time, the second "
            "with the model that the first gave"
        )
    names = [recording.name for recording in recordings if of_encoders_alone(recording)]
    if names and len(names) < len(recordings):
        raise InputError(
            f"{', '.join(names)}: hold two encoders and no torque, beside recordings that hold one; give one kind at a "
            "time, the second with the model that the first gave"
        )

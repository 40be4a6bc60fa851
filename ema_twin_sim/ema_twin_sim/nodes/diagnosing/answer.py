"""A diagnosis as the message that the monitor answers with."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from ema_bench_replay.nodes.messages import header
from ema_twin_msgs.msg import Diagnosis, Effect


def diagnosis_message(diagnosis: Mapping[str, Any], stamp: int, run: int, window: float) -> Diagnosis:
    """A diagnosis, as `diagnose --json` writes it, as a message.

    Args:
        diagnosis: as `Diagnosis.as_json` gives it; numbers that it lacks become NaN.
        stamp: stamp of the last sample that was judged, ns since the epoch.
        run: the run of that sample.
        window: length of what was judged, s.
    """
    return Diagnosis(
        header=header(stamp),
        run=run,
        window=window,
        verdict=diagnosis["verdict"],
        ranking=[_effect(entry) for entry in diagnosis["ranking"]],
        none=diagnosis["none"],
        unknown=diagnosis["unknown"],
        groups=[",".join(group) for group in diagnosis["groups"]],
        depends_on=diagnosis["depends_on"],
        next_recording=diagnosis["next_recording"],
        warnings=diagnosis["warnings"],
    )


def _effect(entry: Mapping[str, Any]) -> Effect:
    parameters = entry["parameters"]
    return Effect(
        id=entry["effect"],
        probability=entry["probability"],
        error_removed=_share(entry["error_removed"]),
        found=entry["found"],
        option=[f"{name}={choice}" for name, choice in entry["options"].items()],
        parameter=list(parameters),
        value=[_number(held["value"]) for held in parameters.values()],
        std=[_number(held["std"]) for held in parameters.values()],
        unit=[held["unit"] for held in parameters.values()],
    )


def _share(value: float | None) -> float:
    """A share of the error, limited to 0 to 1: an effect that makes the error grow removes none of it."""
    return math.nan if value is None or math.isnan(value) else min(max(float(value), 0.0), 1.0)


def _number(value: float | None) -> float:
    return math.nan if value is None else float(value)

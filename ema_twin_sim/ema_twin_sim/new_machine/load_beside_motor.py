"""Whether a load's torque at the output shows a gear of which nobody told: it is many times the motor's torque."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from ema_bench_replay.recording import AT, Recording

from ..criteria import TOO_MUCH
from ..measured.load_sensor import load_over_motor_torque


class ShownGear(NamedTuple):
    """About which gear ratio torques show, in words of a comment and of a question."""

    ratio: float
    comment: str
    question: str


def shown_gear(recordings: Sequence[Recording]) -> ShownGear | None:
    """The gear ratio that load and motor's torque suggest where 1 was assumed; None if they suggest none.

    Friction takes a part of the motor's torque, so that only a factor far from 1 tells of a gear.
    """
    measured = [r for r in recordings if r.motion == "rotary" and r.metadata.get(f"load_torque{AT}") == "output"]
    factor = load_over_motor_torque(measured)
    if factor is None or factor < TOO_MUCH:
        return None
    about = float(f"{factor:.2g}")
    told = f"the load's torque changes about {about:g} times as much as the motor's"
    return ShownGear(
        about,
        f"{told}, as behind a gear",
        f"{measured[0].name}: {told}, though a gear ratio of 1 is assumed: give --gear-ratio with the ratio from the "
        f"data sheet (about {about:g}), or correct the unit of a torque; otherwise every result is wrong",
    )

"""Acquisition: is the effort of a run a magnitude, and is that certain? A load that always pulls one way hides it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..criteria import NEGLIGIBLE
from ..measured.magnitude import looks_like_a_magnitude, moving_rows
from .motion_record import MotionRecord
from .phases import Phases


class Sign(NamedTuple):
    """Whether an effort is a magnitude, and whether the import map or negative efforts leave no doubt of it."""

    unsigned: bool
    certain: bool

    @property
    def words(self) -> str:
        """What is assumed, and how to correct it; empty if the effort certainly has a sign."""
        if not self.unsigned:
            return "" if self.certain else _TAKEN_AS_SIGNED
        how = "is" if self.certain else "is never negative in motion both ways, so it is treated as"
        correct = "" if self.certain else " If it has a sign, write `magnitude: false` below it in the import map."
        return (
            f"The effort {how} unsigned (a magnitude), so a changed load cannot be distinguished from friction that "
            f"differs between the directions.{correct}"
        )


_TAKEN_AS_SIGNED = (
    "The effort is never negative, but goes with the motion as under a load that always pulls one way, so it is taken "
    "with its sign. If it is a magnitude, write `magnitude: true` below it in the import map."
)


def sign_of(record: MotionRecord, phases: Phases) -> Sign:
    """As declared; otherwise an effort is a magnitude if it is never negative in motion both ways, and looks like one.

    Noise makes single efforts negative near zero, so a few do not count.
    """
    if record.unsigned is not None:
        return Sign(record.unsigned, certain=True)
    strokes = phases.strokes(1), phases.strokes(-1)
    if not all(strokes):
        return Sign(unsigned=False, certain=True)
    steady = np.concatenate([record.effort[piece.steady] for way in strokes for piece in way])
    if np.mean(steady < 0.0) > NEGLIGIBLE:
        return Sign(unsigned=False, certain=True)
    period = float(np.median(np.diff(record.time)))
    moving = moving_rows(record.position, period, record.effort, of_speed=False)
    return Sign(looks_like_a_magnitude(moving, record.effort), certain=False)

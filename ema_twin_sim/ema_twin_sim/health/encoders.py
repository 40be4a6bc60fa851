"""Manipulation: how far two encoders, at the motor and at the output, part over the steady strokes of a run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..criteria import ALL_BUT_SPIKES
from .motion_record import MotionRecord, rounding_scatter
from .phases import Phases

NEARLY_REPEATABLE = ("encoder_reach", "encoder_scatter", "encoder_drift")
"""The features that repeat within a fraction of a per cent, mostly as the rounding of the encoders does. Changes below
those of a sensor's calibration (NEGLIGIBLE) say nothing of the machine, and any change of the motion moves these
features by standard deviations."""
_REACHED = (1.0 - ALL_BUT_SPIKES, ALL_BUT_SPIKES)  # of the samples


@dataclass(frozen=True)
class EncodersApart:
    """The distance between two encoders, in the position's unit."""

    lost_motion: float  # play and wind-up: how far the motor's leads in either direction (half the total)
    scatter: float  # about its mean over a stroke: an encoder that runs eccentrically
    reach: float  # half of how far they part over the whole run, while starting and braking too
    drift: float | None  # from stroke to stroke of one direction: an encoder that slips; None if no way was gone twice


def encoders_apart(record: MotionRecord, phases: Phases) -> EncodersApart:
    """How the distance between both encoders differs between the directions, within a stroke and between strokes.

    The scale of the motor's is fitted over the run, so the gear ratio need not be known. Each stroke counts once: in a
    long slow one an output that coasts floats anywhere in the gap. No scatter is less than that of rounding to the
    encoders' smallest steps.
    """
    assert record.motor_position is not None
    sides = [phases.strokes(1), phases.strokes(-1)]
    strokes = sides[0] + sides[1]
    rows = [np.r_[p.steady] for p in strokes]
    which = np.repeat(np.eye(len(rows)), [len(part) for part in rows], axis=0)
    every = np.concatenate(rows)
    columns = np.column_stack([which, record.motor_position[every]])
    fitted = np.linalg.lstsq(columns, record.position[every], rcond=None)[0]
    places, scale = np.split(fitted[:-1], [len(sides[0])]), float(fitted[-1])
    left = record.position[every] - columns @ fitted
    floor = np.hypot(rounding_scatter(record.position), scale * rounding_scatter(record.motor_position))
    ends = np.cumsum([len(part) for part in rows])[:-1]
    within = [np.hypot(part.std(), floor) for part in np.split(left, ends)]
    ends_of_all = np.quantile(record.position - scale * record.motor_position, _REACHED)
    between = [float(side.var(ddof=1)) for side in places if len(side) > 1]
    return EncodersApart(
        0.5 * float(places[1].mean() - places[0].mean()),
        float(np.exp(np.mean(np.log(np.maximum(within, np.finfo(float).tiny))))),
        0.5 * float(np.ptp(ends_of_all)),
        float(np.hypot(np.sqrt(np.mean(between)), floor)) if between else None,
    )

"""Spoilt samples: single-sample transmission errors, and places where a counter lost counts."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from ema_bench_replay.long_columns import Column, by_pieces, pieces, places_where, values_at
from ema_bench_replay.recording import AT, Recording

from ..criteria import LIKELY, NEARLY_ALL, NEGLIGIBLE, PART, SPIKE
from ..listing import number_of
from .sliding import moving_maximum, moving_median

MOTION = ("speed", "motor_position", "output_position")
FEWEST = 5  # samples among which one can stand alone
TOLD = 3  # places in a warning
ROUNDING = 1e-12  # of the largest value: less is an error of arithmetic
NEIGHBOURS = 7  # samples; the middle one stands out where counts were lost


def despiked(values: np.ndarray) -> np.ndarray:
    """Values (n,) with the mean of their neighbours in place of transmission errors."""
    wild = spoilt(values)
    if not wild.any():
        return values
    kept = values.copy()
    kept[wild] = 0.5 * (values[np.roll(wild, -1)] + values[np.roll(wild, 1)])
    return kept


def spoilt(values: np.ndarray) -> np.ndarray:
    """Which values (n,) are single samples far off the line between their neighbours: transmission errors."""
    wild = np.zeros(len(values), bool)
    known = np.flatnonzero(np.isfinite(values))
    if len(known) < FEWEST:
        return wild
    values = values[known]
    out = values[1:-1] - 0.5 * (values[:-2] + values[2:])
    # of a signal in steps most samples are on a line, but for rounding errors
    spread = max(1.4826 * float(np.median(np.abs(out))), float(np.quantile(np.abs(out), NEARLY_ALL)) / LIKELY)
    if not spread > ROUNDING * float(np.abs(values).max()):
        return wild
    # next to a spike both neighbours deviate by half of it in the opposite direction; next to a corner they do not
    before, after = np.r_[0.0, out[:-1]], np.r_[out[1:], 0.0]
    # a sample that was taken late is off by less than goes on between its neighbours
    far = np.abs(out) > np.maximum(SPIKE * spread, np.abs(values[2:] - values[:-2]))
    far &= (before * out < -PART * out**2) & (after * out < -PART * out**2)
    wild[known[1:-1][far]] = True
    return wild


def without_spoilt_motion(recording: Recording) -> Recording:
    """The recording with transmission errors of its speed and positions unknown, and a warning that says where.

    A speed is in error only if a position that was measured beside it does not go along. What happens in more than a
    few samples is what the machine does.
    """
    if recording.of_points:
        return recording
    signals, warnings = dict(recording.signals), [*recording.warnings]
    for name in MOTION:
        if not recording.has(name):
            continue
        places = places_where(lambda part: part, by_pieces(spoilt, signals[name], margin=1))
        shafts = {recording.metadata.get(f"{signal}{AT}") for signal in ("speed", "motor_position")}
        if name == "speed" and recording.has("motor_position") and len(shafts) == 1:
            places = places[~_position_goes_along(recording, places)]
        if not 0 < len(places) < NEGLIGIBLE * len(recording):
            continue
        signals[name] = _unknown_at(signals[name], places)
        told = ", ".join(f"{recording.time[place]:.3f}" for place in places[:TOLD])
        more = " …" if len(places) > TOLD else ""
        warnings.append(
            f"{recording.name}: {number_of(len(places), 'single sample')} of {name} far off the samples before and "
            f"after, as transmission errors are: left out, at {told}{more} s"
        )
    if len(warnings) == len(recording.warnings):
        return recording
    return replace(recording, signals=signals, warnings=tuple(warnings))


def _position_goes_along(recording: Recording, places: np.ndarray) -> np.ndarray:
    """Whether the position moves (m,) as a speed says that stands alone at some ``places`` (m,) of a recording."""
    speed, position = recording.signals["speed"], recording.signals["motor_position"]
    before, here, after = (values_at(speed, places + k) for k in (-1, 0, 1))
    came, went = (values_at(position, places + k) for k in (-1, 1))
    lasts = 0.5 * (values_at(recording.time, places + 1) - values_at(recording.time, places - 1))
    alone = lasts * (here - 0.5 * (before + after))
    moved: np.ndarray = (went - came) - lasts * (before + after)
    return moved * np.sign(alone) > PART * np.abs(alone)


def _unknown_at(values: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Values (n,) with NaN at some places (m,)."""
    made = Column(np.float64)
    for rows in pieces(len(values)):
        part = np.array(values[rows], np.float64)
        part[places[(places >= rows.start) & (places < rows.stop)] - rows.start] = np.nan
        made.add(part)
    return made.finish()


def counter_jumps(difference: np.ndarray, travel: np.ndarray, counted: float) -> np.ndarray:
    """Permanent jumps (n,) [rad] of the encoder difference at each sample; mostly zero.

    A counter lost counts there, or its repair took a transmission error for a loss. A step counts as a jump if it
    exceeds the noise plus ``travel`` (n,) [rad] (the motion within a sample, by which the encoders may separate where
    an output is hit) plus ``counted`` [rad] (the counting resolution) plus twice the rate of an output in flight. Such
    an output is faster than a motor that reverses: it may return from its teeth as fast as it separated a sample
    before, or a sample after. It flies for three samples or more, while counts may be lost over two.
    """
    step = np.diff(difference, prepend=difference[:1])
    out = step - moving_median(step, NEIGHBOURS)
    spread = 1.4826 * float(np.median(np.abs(out)))
    most = SPIKE * spread + moving_maximum(np.abs(travel), NEIGHBOURS // 2, NEIGHBOURS // 2) + counted
    return np.where(np.abs(out) > most + 2.0 * _in_flight(step, np.sign(out)), out, 0.0)


def _in_flight(step: np.ndarray, way: np.ndarray) -> np.ndarray:
    """Rate (n,) [rad per sample] at which the encoders separate around each sample.

    Against the direction ``way`` (n,) of its step, or along it for three samples.
    """
    long_before, before, _, after, long_after = np.lib.stride_tricks.sliding_window_view(np.pad(step, 2, "edge"), 5).T
    back = np.maximum(-way * before, -way * after)
    along = [way * one for one in (long_before, before, after, long_after)]
    flight = np.max([np.minimum(one, other) for one, other in pairwise(along)], axis=0)
    return np.maximum(np.maximum(back, flight), 0.0)

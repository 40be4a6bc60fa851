"""Spoilt samples: single-sample transmission errors, and places where a counter lost counts."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from ..criteria import PART, SPIKE
from .sliding import moving_maximum, moving_median

NEIGHBOURS = 7  # samples; the middle one stands out where counts were lost


def despiked(values: np.ndarray) -> np.ndarray:
    """Values (n,) without single samples far off the line between their neighbours: transmission errors."""
    middle = 0.5 * (values[:-2] + values[2:])
    out = values[1:-1] - middle
    spread = 1.4826 * float(np.median(np.abs(out)))
    # next to a spike both neighbours deviate by half of it in the opposite direction; next to a corner they do not
    before, after = np.r_[0.0, out[:-1]], np.r_[out[1:], 0.0]
    wild = (np.abs(out) > SPIKE * spread) & (before * out < -PART * out**2) & (after * out < -PART * out**2)
    if spread == 0.0 or not wild.any():
        return values
    kept = values.copy()
    kept[1:-1][wild] = middle[wild]
    return kept


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

"""Spoilt samples: transmission errors of a single sample, and places where a counter has lost counts."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from ..criteria import PART, SPIKE
from .sliding import moving_maximum, moving_median

NEIGHBOURS = 7  # samples, of which the middle one stands out where counts were lost


def despiked(values: np.ndarray) -> np.ndarray:
    """The values (n,) without single samples that stand far out of their neighbours' line: transmission errors."""
    middle = 0.5 * (values[:-2] + values[2:])
    out = values[1:-1] - middle
    spread = 1.4826 * float(np.median(np.abs(out)))
    # beside a spike both neighbours stand out by half of it the other way; beside a corner they do not stand out
    before, after = np.r_[0.0, out[:-1]], np.r_[out[1:], 0.0]
    wild = (np.abs(out) > SPIKE * spread) & (before * out < -PART * out**2) & (after * out < -PART * out**2)
    if spread == 0.0 or not wild.any():
        return values
    kept = values.copy()
    kept[1:-1][wild] = middle[wild]
    return kept


def counter_jumps(difference: np.ndarray, travel: np.ndarray, counted: float) -> np.ndarray:
    """By how much (n,) [rad] the encoders' difference jumps for good at a sample, mostly zero.

    A counter has lost counts there, or its repair took a transmission error for that. ``travel`` (n,) [rad] is the way
    of a sample: by so much the encoders may part where an output is hit; and by what is ``counted`` [rad] at a time.
    An output that flies through its play is quicker than a motor that turns back: it may come back from its teeth as
    fast as it parted a sample before, or does a sample after; and it flies for three samples or more, while counts may
    be lost over two.
    """
    step = np.diff(difference, prepend=difference[:1])
    out = step - moving_median(step, NEIGHBOURS)
    spread = 1.4826 * float(np.median(np.abs(out)))
    most = SPIKE * spread + moving_maximum(np.abs(travel), NEIGHBOURS // 2, NEIGHBOURS // 2) + counted
    return np.where(np.abs(out) > most + 2.0 * _in_flight(step, np.sign(out)), out, 0.0)


def _in_flight(step: np.ndarray, way: np.ndarray) -> np.ndarray:
    """How fast (n,) [rad a sample] the encoders part around each sample: back from the ``way`` (n,) that its step goes,
    or that way for three samples.
    """
    long_before, before, _, after, long_after = np.lib.stride_tricks.sliding_window_view(np.pad(step, 2, "edge"), 5).T
    back = np.maximum(-way * before, -way * after)
    along = [way * one for one in (long_before, before, after, long_after)]
    flight = np.max([np.minimum(one, other) for one, other in pairwise(along)], axis=0)
    return np.maximum(np.maximum(back, flight), 0.0)

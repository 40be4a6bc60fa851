"""Encoder counters: unwrap their word, find and remove jumps, and report every finding."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ema_bench_replay.long_columns import Column, by_pieces, differences, median, pieces, places_where

# A jump this close (in revolutions) to a power of two or to whole revolutions is rounded to it.
_NEAR = 0.005
# If the next step reverses a jump to within this share, it is a single wrong reading.
_WAY_BACK = 0.1
# Number of neighbouring steps on either side that predict the speed of a step.
_SEEN = 3
# Smaller powers of two are not taken as a counter's word.
_SMALLEST_POWER = 12
# Deviations up to this many robust standard deviations are encoder noise.
_NOISE_FACTOR = 10.0


@dataclass(frozen=True)
class Finding:
    """A change of the counter that is not a motion of the shaft."""

    kind: str  # "wrap" or "jump"
    sample: int  # the first sample after it
    counts: int  # excess counts from there on, which were subtracted
    revolutions: float  # the same
    whole: bool  # whether these are whole revolutions (then the counter's angle still matches the shaft's)

    def describe(self, time: float) -> str:
        """The finding in words; `time` is that of its sample, in s."""
        if self.kind == "wrap":
            return f"counter wrapped ({self.counts:+d} counts) at {time:.3f} s; unwrapped"
        size = "whole revolutions" if self.whole else "not whole"
        jump = f"{self.counts:+d} counts ({self.revolutions:+.4g} revolutions, {size})"
        return f"counter jumped by {jump} at {time:.3f} s; repaired"


def unwrap_counts(
    raw: np.ndarray,
    time: np.ndarray,
    counts_per_revolution: float,
    *,
    bits: int = 32,
    maximum_speed: float = math.inf,
    maximum_acceleration: float = math.inf,
) -> tuple[np.ndarray, list[Finding]]:
    """The counts along the shaft's motion, starting from the counter's first reading.

    A step of more than half the counter's word is a wrap. A step is a jump if it exceeds `maximum_speed`, or if it
    deviates from its neighbours' prediction by more than `maximum_acceleration` allows in one sample period (and by
    more than the encoder's noise). The predicted part of a jump is kept. If the excess is near whole revolutions or a
    power of two, exactly that is removed; an excess that the next step reverses is removed exactly.

    Args:
        raw: counter readings, int64 (n,), or float64 if they have fractions.
        time: s, float64 (n,), strictly increasing.
        counts_per_revolution: of the shaft that carries the counter.
        bits: width of the counter's word. It may be read as signed or as unsigned.
        maximum_speed: of that shaft, rad/s.
        maximum_acceleration: of that shaft, rad/s².

    Returns:
        Repaired counts (n,) of the same dtype as `raw`, and the findings in order of time.
    """
    if raw.size < 2:
        return raw.copy(), []
    word = 1 << bits
    steps = differences(raw)
    findings = []
    if all(raw[rows].min() >= -word // 2 and raw[rows].max() < word for rows in pieces(raw.size)):
        for place in places_where(lambda step: np.rint(step / word) != 0.0, steps).tolist():
            size = round(float(steps[place] / word)) * word
            findings.append(Finding("wrap", place + 1, size, size / counts_per_revolution, False))
        steps = by_pieces(lambda step: step - np.rint(step / word).astype(step.dtype) * word, steps)
    period = differences(time)
    radian = counts_per_revolution / (2 * math.pi)
    predicted = by_pieces(_predicted_speed, by_pieces(np.divide, steps, period), margin=_SEEN)
    excess = by_pieces(lambda step, speed, duration: step - speed * duration, steps, predicted, period)
    noise = 1.4826 * median(lambda: (np.abs(excess[rows]) for rows in pieces(excess.size)))

    def impossible(step: np.ndarray, beyond: np.ndarray, duration: np.ndarray) -> np.ndarray:
        possible = maximum_acceleration * radian * duration**2 + _NOISE_FACTOR * noise + 2.0
        too_fast = np.abs(step) > maximum_speed * radian * duration + _NOISE_FACTOR * noise + 2.0
        return too_fast | (np.abs(beyond) > possible)

    jumps = places_where(impossible, steps, excess, period).tolist()
    size, whole = 0, False
    taken_out: dict[int, int] = {}  # by step
    for place, comes_back in _with_the_way_back(jumps, excess).items():
        size, whole = (-size, whole) if comes_back else _jump_size(float(excess[place]), counts_per_revolution)
        if size:
            findings.append(Finding("jump", place + 1, size, size / counts_per_revolution, whole))
            taken_out[place] = size
    if not findings:
        return raw, []
    return _summed(raw[:1], steps, taken_out), sorted(findings, key=lambda finding: finding.sample)


def _summed(first: np.ndarray, steps: np.ndarray, taken_out: dict[int, int]) -> np.ndarray:
    """The counts (n,): the first one (1,) plus the sum of the steps (n - 1,), reduced by what is removed."""
    places, sizes = np.array(sorted(taken_out), int), np.array([taken_out[place] for place in sorted(taken_out)])
    counts = Column(first.dtype)
    counts.add(first)
    last = first[0]
    for rows in pieces(len(steps)):
        here = slice(*np.searchsorted(places, (rows.start, rows.stop)))
        left = steps[rows].copy()
        left[places[here] - rows.start] -= sizes[here].astype(left.dtype)
        went = last + np.cumsum(left)
        counts.add(went)
        last = went[-1]
    return counts.finish()


def _with_the_way_back(places: list[int], excess: np.ndarray) -> dict[int, bool]:
    """The steps that are jumps, in order, and whether each reverses the one before it.

    A single wrong reading makes a jump there and one back; if only one of them is physically impossible, the other one
    is a jump, too.
    """
    found = dict.fromkeys(places, False)
    for place in places:
        for first in (place - 1, place):
            if first < 0 or first + 1 >= len(excess) or found.get(first):
                continue
            there, back = float(excess[first]), float(excess[first + 1])
            if abs(there + back) <= _WAY_BACK * abs(float(excess[place])):
                found[first] = False
                found[first + 1] = True
    return dict(sorted(found.items()))


def _predicted_speed(speed: np.ndarray) -> np.ndarray:
    """Predicted speed of each step: the mean of the medians of the three before and the three after it.

    At either end, where fewer than three exist, only the other side is used.
    """
    if speed.size < 7:
        return np.full(speed.size, np.median(speed))
    medians = _median_of_three(speed[:-2], speed[1:-1], speed[2:])  # medians[i]: of the steps i, i + 1, i + 2
    before = np.concatenate((medians[1:4], medians[:-1]))
    after = np.concatenate((medians[1:], medians[-4:-1]))
    return (before + after) / 2


def _median_of_three(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    return np.maximum(np.minimum(a, b), np.minimum(np.maximum(a, b), c))


def _jump_size(excess: float, counts_per_revolution: float) -> tuple[int, bool]:
    """Counts to remove, and whether they are whole revolutions."""
    near = _NEAR * counts_per_revolution
    revolutions = round(excess / counts_per_revolution)
    if revolutions and abs(excess - revolutions * counts_per_revolution) <= near:
        return round(revolutions * counts_per_revolution), True
    power = 1 << max(round(math.log2(abs(excess))), 0) if excess else 0
    if power >= 1 << _SMALLEST_POWER and abs(abs(excess) - power) <= min(near, power / 64):
        return int(math.copysign(power, excess)), False
    return round(excess), False

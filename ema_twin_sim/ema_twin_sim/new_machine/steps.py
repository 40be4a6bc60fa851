"""The steps of a counter, seen in its values."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..criteria import NEARLY_ALL, NEGLIGIBLE, PART

_SHARES = (0.2, 0.05)  # of the steps between neighbouring values that may be single steps


def smallest_step(values: np.ndarray) -> float | None:
    """The step of which all differences between a counter's values (n,) are multiples; None if there is none.

    Also None if nearly all samples that advance do so by exactly one such step, one after the other: a shaft that turns
    steadily does so too. A shaft that turns fast shows single steps only where it reverses.
    """
    steps = np.diff(np.unique(values))
    for share in _SHARES if len(steps) else ():
        smallest = float(np.median(steps[steps <= 1.5 * np.quantile(steps, share)]))
        parts = steps / smallest
        if _is_steady(np.rint(np.abs(np.diff(values)) / smallest)):
            return None
        if float(np.quantile(np.abs(parts - np.rint(parts)), 0.9)) < 0.1:
            return smallest
    return None


def common_step(recordings: Sequence[np.ndarray]) -> float | None:
    """The step of one counter in all of its recordings' values (n,) each; None if there is none, or if one is finer."""
    found = [smallest_step(values) for values in recordings]
    step = min((each for each in found if each is not None), default=None)
    unknown = [values for values, each in zip(recordings, found, strict=True) if each is None]
    return None if step is None or any(_is_finer(values, step) for values in unknown) else step


def _is_steady(advances: np.ndarray) -> bool:
    """Whether the numbers of steps between samples (n,) are those of a steady motion: one each, without a pause."""
    moves = advances > 0.0
    follows = moves[1:][moves[:-1]]
    if not len(follows) or float(np.mean(advances[moves] == 1.0)) < NEARLY_ALL:
        return False
    return float(np.mean(follows)) >= NEARLY_ALL


def _is_finer(values: np.ndarray, step: float) -> bool:
    """Whether a considerable share of the differences between values (n,) is less than half a step."""
    steps = np.diff(np.unique(values))
    return len(steps) > 0 and float(np.mean(steps < 0.5 * step)) >= PART


def is_decimal(step: float, digits: Sequence[float] = (1.0, 2.0, 5.0)) -> bool:
    """Whether a step is one of these ``digits`` of a decimal place."""
    leading = step / 10.0 ** math.floor(math.log10(step) + NEGLIGIBLE)
    return any(abs(leading / digit - 1.0) < NEGLIGIBLE for digit in digits)

"""The noise of a single reading of a smooth signal, from the signal itself."""

from __future__ import annotations

import numpy as np


def reading_noise(values: np.ndarray) -> float:
    """Standard deviation of the white noise on a smooth signal (n,), by its third differences, robustly."""
    if len(values) < 4:
        return 0.0
    third = np.diff(values, 3)
    return float(1.4826 * np.median(np.abs(third - np.median(third))) / np.sqrt(20.0))

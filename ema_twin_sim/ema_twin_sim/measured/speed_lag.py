"""The lag of a drive's speed behind its position: the time constant of the drive's smoothing.

A speed v after a first-order filter with the time constant T satisfies T·v + ∫v dt = position, however the motor moves.
So one regression without a derivative finds T, to far less than a sample.
"""

from __future__ import annotations

import math

import numpy as np

from ema_bench_replay.recording import Recording

from ..criteria import SIGNIFICANT, SMALL

_BLOCKS = 10  # blocks of the recording, each of which is left out once
_FEWEST = 40  # minimum number of samples of a block


def speed_lag(recording: Recording) -> float | None:
    """The lag [s] of a recording's speed, which is of the same shaft as its position; None if it shows none."""
    if recording.of_points or not recording.has("motor_position", "speed"):
        return None
    position, speed = recording.signals["motor_position"], recording.signals["speed"]
    known = np.isfinite(position) & np.isfinite(speed)
    if known.sum() < _BLOCKS * _FEWEST:
        return None
    time, position, speed = recording.time[known], position[known], speed[known]
    way = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(time))])
    columns = np.stack([way, speed, time, np.ones(len(time))], axis=1)
    scale = np.abs(columns).max(axis=0)
    if not scale.all():
        return None
    parts = np.array_split(np.arange(len(time)), _BLOCKS)
    squares = np.array([(columns[part] / scale).T @ (columns[part] / scale) for part in parts])
    products = np.array([(columns[part] / scale).T @ position[part] for part in parts])

    def solved(square: np.ndarray, product: np.ndarray) -> np.ndarray:
        return np.linalg.lstsq(square, product, rcond=1e-12)[0] / scale

    whole, lag, *_ = solved(squares.sum(axis=0), products.sum(axis=0))
    without = [
        solved(squares.sum(axis=0) - s, products.sum(axis=0) - p) for s, p in zip(squares, products, strict=True)
    ]
    error = math.sqrt((_BLOCKS - 1) * float(np.var([found[1] for found in without])))
    if abs(whole - 1.0) > SMALL or lag < SIGNIFICANT * error:  # another shaft or unit, or no lag
        return None
    return float(lag / whole) or None

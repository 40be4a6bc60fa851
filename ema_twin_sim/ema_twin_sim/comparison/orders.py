"""The order of a residual: how often per motor revolution it repeats, how large it is there, and its phase."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..criteria import CLEARLY_MORE

_ANGLE_BINS = 512  # per revolution: orders up to 256
_STEP = 0.02
ORDERS = np.arange(0.2, 160.0, _STEP)
"""The orders of a ``Periodicity``'s spectrum."""
_REFINED = 11  # orders tried around the best of the grid
_FEWEST_CYCLES = 3.0  # an order needs that many cycles in a recording to be one
_FEWEST_SAMPLES = 160
_ENOUGH = 50_000  # samples that settle amplitude and phase
_LARGEST = 1 << 22  # angle bins


@dataclass(frozen=True)
class Periodicity:
    """The strongest order of a residual: amplitude * sin(order * motor angle + phase), times direction if dissipative.

    ``share`` is the part of the residual's power that it explains, ``spectrum`` the amplitude over ``ORDERS``.
    """

    order: float
    amplitude: float
    phase: float  # rad at the motor counter's zero
    share: float
    dissipative: bool | None  # None where the recordings do not tell
    spectrum: np.ndarray


def find_order(
    parts: Sequence[tuple[np.ndarray, np.ndarray, np.ndarray]], *, resolved: bool = False
) -> Periodicity | None:
    """The strongest order in parts of (residual, motor angle [rad], direction -1 or 1), each (n,) and moving.

    Where only what is ``resolved`` counts, orders of which a part has fewer than two samples a cycle at its usual top
    speed are left out of it: a lower one, of the output's turns, looks like any of them. None where no part turns far
    enough.
    """
    plain, flipped = np.zeros_like(ORDERS), np.zeros_like(ORDERS)
    used = [part for part in parts if len(part[0]) >= _FEWEST_SAMPLES]
    for residual, angle, direction in used:
        counts = highest_resolved(angle) > ORDERS if resolved else True
        plain += _power(ORDERS, residual, angle) * counts
        flipped += _power(ORDERS, residual * direction, angle) * counts
    if not plain.any():
        return None
    dissipative = bool(flipped.max() > plain.max())
    clear = max(flipped.max(), plain.max()) > CLEARLY_MORE**2 * min(flipped.max(), plain.max())
    power = flipped if dissipative else plain
    best = int(np.argmax(power))
    residual, angle, direction = (np.concatenate(columns) for columns in zip(*used, strict=True))
    every = max(1, len(residual) // _ENOUGH)
    residual, angle, direction = residual[::every], angle[::every], direction[::every]
    if dissipative:
        residual = residual * direction
    near = ORDERS[best] + _STEP * np.linspace(-1.0, 1.0, _REFINED)
    order, a, b, explained = max((_fit(order, residual, angle) for order in near), key=lambda fit: fit[-1])
    return Periodicity(
        order,
        math.hypot(a, b),
        math.atan2(b, a),
        explained / float(np.mean(residual**2)),
        dissipative if clear else None,
        np.sqrt(2.0 * power / sum(len(part[0]) for part in used)),
    )


def highest_resolved(angle: np.ndarray) -> float:
    """The order of which an angle (n,) [rad] has two samples a cycle at its usual top speed; infinite at rest."""
    step = float(np.quantile(np.abs(np.diff(angle)), 0.95))
    return math.pi / step if step > 0.0 else math.inf


def _fit(order: float, residual: np.ndarray, angle: np.ndarray) -> tuple[float, float, float, float]:
    """(order, sine part, cosine part, mean power explained) of the least-squares wave of one order."""
    waves = np.column_stack([np.sin(order * angle), np.cos(order * angle)])
    parts, *_ = np.linalg.lstsq(waves, residual, rcond=None)
    return float(order), float(parts[0]), float(parts[1]), float(np.mean((waves @ parts) ** 2))


def _power(orders: np.ndarray, residual: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Power of a residual at each order, sum over its samples; zero where it has too few cycles of one."""
    place = np.floor(angle * (_ANGLE_BINS / (2.0 * math.pi))).astype(np.int64)
    place -= place.min()
    bins = int(place.max()) + 1
    if bins > _LARGEST:
        return np.zeros_like(orders)
    # without its mean, or a constant error would leak into low orders
    summed = np.bincount(place, residual - residual.mean(), bins)
    length = 1 << max(12, (4 * bins - 1).bit_length())
    spectrum = np.abs(np.fft.rfft(summed, length)) ** 2 * 2.0 / len(residual)
    here = np.interp(orders, np.arange(len(spectrum)) * _ANGLE_BINS / length, spectrum)
    return np.where(orders * bins / _ANGLE_BINS >= _FEWEST_CYCLES, here, 0.0)

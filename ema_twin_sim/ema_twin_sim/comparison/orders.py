"""Order of a residual: how often it repeats per motor revolution, with amplitude and phase."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ema_bench_replay.long_columns import by_pieces, joined, overlapping, quantile, values_at

from ..criteria import CLEARLY_MORE
from ..measured.order_spectrum import largest_in_cells, line_turns, refined

_STEP = 0.02
ORDERS = np.arange(0.2, 160.0, _STEP)
"""The orders of a ``Periodicity``'s spectrum; each represents the range within half a step."""
_REFINED = 10  # orders tried within the width of a line
_MOST_REFINED = 201
_POLISHED = 3  # Newton steps from the best of these
FEWEST_CYCLES = 3.0  # cycles in a recording that an order needs
FEWEST_SAMPLES = 160
_ENOUGH = 50_000  # samples that are enough for amplitude and phase


@dataclass(frozen=True)
class Periodicity:
    """The strongest order of a residual: amplitude * sin(order * motor angle + phase), times direction if dissipative.

    ``share`` is the part of the residual's power that it explains, ``spectrum`` the amplitude over ``ORDERS``.
    """

    order: float
    amplitude: float
    phase: float  # rad at the motor counter's zero
    share: float
    dissipative: bool | None  # None if the recordings do not decide
    spectrum: np.ndarray
    order_std: float  # standard error of the order, for a white residual


def find_order(
    parts: Sequence[tuple[np.ndarray, np.ndarray, np.ndarray]], *, resolved: bool = False
) -> Periodicity | None:
    """The strongest order in parts of (residual, motor angle [rad], direction -1 or 1), each (n,) and moving.

    With ``resolved``, a part does not count for orders of which it has fewer than two samples a cycle at its usual top
    speed: a lower order, or a constant, looks like any of them. None if no part turns far enough, or so slowly that
    its samples tell any order.
    """
    plain, flipped, samples = np.zeros_like(ORDERS), np.zeros_like(ORDERS), np.zeros_like(ORDERS)
    used = [part for part in parts if _tells_orders(part[1])]
    for residual, angle, direction in used:
        counts = highest_resolved(angle) > ORDERS if resolved else np.full(len(ORDERS), True)
        samples += len(residual) * counts
        plain += largest_in_cells(ORDERS, residual, angle, FEWEST_CYCLES) * counts
        flipped += largest_in_cells(ORDERS, by_pieces(np.multiply, residual, direction), angle, FEWEST_CYCLES) * counts
    if not plain.any():
        return None
    dissipative = bool(flipped.max() > plain.max())
    clear = max(flipped.max(), plain.max()) > CLEARLY_MORE**2 * min(flipped.max(), plain.max())
    power = flipped if dissipative else plain
    if dissipative:
        used = [(by_pieces(np.multiply, residual, direction), angle, direction) for residual, angle, direction in used]
    strongest = float(ORDERS[int(np.argmax(power))])
    if resolved:
        used = [part for part in used if highest_resolved(part[1]) > strongest]
    best = refined(strongest, _STEP, [part[:2] for part in used])
    residual, angle = (joined([part[k] for part in used]) for k in (0, 1))
    if len(residual) > _ENOUGH:  # random, since every n-th sample would alias orders
        rows = np.random.default_rng(0).choice(len(residual), _ENOUGH, replace=False)
        residual, angle = values_at(residual, rows), values_at(angle, rows)
    near = best + _around(angle, line_turns([part[1] for part in used]))
    order, a, b, explained = max((_fit(order, residual, angle) for order in near), key=lambda fit: fit[-1])
    std = math.inf
    for _ in range(_POLISHED):
        step, std = _newton_step(order, a, b, residual, angle)
        trial = _fit(order + step, residual, angle)
        if trial[-1] <= explained:
            break
        order, a, b, explained = trial
    return Periodicity(
        order,
        math.hypot(a, b),
        math.atan2(b, a),
        explained / float(np.mean(residual**2)),
        dissipative if clear else None,
        _amplitudes(power, samples),
        std,
    )


def amplitude_spectrum(parts: Sequence[tuple[np.ndarray, np.ndarray]]) -> np.ndarray | None:
    """Amplitude over ``ORDERS`` of parts of (residual, motor angle [rad]), each (n,) and moving.

    None if no part turns far enough, or so slowly that its samples tell any order.
    """
    used = [part for part in parts if _tells_orders(part[1])]
    power = np.zeros_like(ORDERS)
    for residual, angle in used:
        power += largest_in_cells(ORDERS, residual, angle, FEWEST_CYCLES)
    return _amplitudes(power, sum(len(residual) for residual, _ in used)) if power.any() else None


def _amplitudes(power: np.ndarray, samples: np.ndarray | int) -> np.ndarray:
    """Amplitudes (m,) of waves that have this ``power`` (m,) in so many ``samples`` of all parts together."""
    return np.sqrt(2.0 * power / np.maximum(samples, 1))


def _tells_orders(angle: np.ndarray) -> bool:
    """Whether an angle (n,) [rad] has enough samples, and at its usual top speed two of them in a cycle of some order.

    A motor that turns several times from sample to sample tells none, and its many turns would take minutes.
    """
    return len(angle) >= FEWEST_SAMPLES and highest_resolved(angle) > ORDERS[0]


def highest_resolved(angle: np.ndarray) -> float:
    """Order for which an angle (n,) [rad] has two samples a cycle at its usual top speed; infinite at rest."""
    step = quantile(lambda: (np.abs(np.diff(part)) for part in overlapping(angle)), 0.95)
    return math.pi / step if step > 0.0 else math.inf


def _around(angle: np.ndarray, turns: float) -> np.ndarray:
    """Offsets at which to search near an order for that of a single wave through all parts.

    The angles of the parts may lie farther apart than the ``turns`` by which the order is known.
    """
    within = min(_STEP, 1.0 / turns)
    half = math.ceil(_REFINED * within * max(turns, float(np.ptp(angle)) / (2.0 * math.pi)))
    half = min(max(half, _REFINED), _MOST_REFINED // 2)
    return within * np.arange(-half, half + 1) / half


def _newton_step(order: float, a: float, b: float, residual: np.ndarray, angle: np.ndarray) -> tuple[float, float]:
    """(step to a better order, its standard error) for a wave a * sin + b * cos of one order."""
    sine, cosine = np.sin(order * angle), np.cos(order * angle)
    slopes = np.column_stack([sine, cosine, angle * (a * cosine - b * sine)])
    size = np.maximum(np.linalg.norm(slopes, axis=0), 1e-300)
    slopes = slopes / size
    left = residual - a * sine - b * cosine
    found, *_ = np.linalg.lstsq(slopes, left, rcond=None)
    noise = float(np.mean((left - slopes @ found) ** 2))
    return float(found[2] / size[2]), math.sqrt(noise * float(np.linalg.pinv(slopes.T @ slopes)[2, 2])) / float(size[2])


def _fit(order: float, residual: np.ndarray, angle: np.ndarray) -> tuple[float, float, float, float]:
    """(order, sine part, cosine part, mean power explained) of the least-squares wave of one order."""
    waves = np.column_stack([np.sin(order * angle), np.cos(order * angle)])
    parts, *_ = np.linalg.lstsq(waves, residual, rcond=None)
    return float(order), float(parts[0]), float(parts[1]), float(np.mean((waves @ parts) ** 2))

"""Where a model fails: the residual against speed, direction, output position, time and order, the worst in words.

For each variable the residual is averaged within bins. What the bins' means explain of its power (adjusted for their
number) is the variable's share: 0 for noise, 1 for an error that is a function of that variable alone.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

_BINS = 16
_SPEED_SHARES = (0.0, 0.02, 0.05, 0.1, 0.2, 0.35, 0.55, 0.8, 1.0)  # of the usual top speed
_STANDSTILL = 0.3  # rad/s of the fast shaft: below it a direction means little
_ANGLE_BINS = 256  # per revolution: orders up to 128
_LOWEST_ORDER, _HIGHEST_ORDER, _ORDER_STEP = 0.2, 60.0, 0.02
_FEWEST_CYCLES = 3.0  # an order needs that many cycles in a recording to be one


@dataclass(frozen=True)
class Stretch:
    """What one recording gives to the search, float64 (n,) each: residual, and the variables it may depend on."""

    residual: np.ndarray  # in the signal's SI unit
    speed: np.ndarray  # rad/s, fast shaft
    motor_angle: np.ndarray  # rad, fast shaft, the counter's own
    output_position: np.ndarray  # rad, slow shaft
    time: np.ndarray  # s


@dataclass(frozen=True)
class Dependence:
    """How a signal's residual depends on one variable, with the place where it is worst."""

    signal: str
    unit: str
    variable: str
    share: float
    lower: float
    upper: float
    variable_unit: str
    rmse_there: float
    rmse_elsewhere: float
    profile: tuple[float, ...]  # RMSE per bin, bins from the variable's lowest value to its highest
    place: str  # where it is worst, in words
    means: tuple[tuple[float, str], tuple[float, str]] | None  # the lowest and the highest mean of a bin, and where

    def as_json(self) -> dict[str, object]:
        """For ``compare --json``."""
        return {
            "signal": self.signal,
            "variable": self.variable,
            "share": self.share,
            "at": {"from": self.lower, "to": self.upper, "unit": self.variable_unit},
            "rmse_there": self.rmse_there,
            "rmse_elsewhere": self.rmse_elsewhere,
            "unit": self.unit,
            "profile": list(self.profile),
            "place": self.place,
        }


def find_dependences(signal: str, unit: str, stretches: Sequence[Stretch]) -> list[Dependence]:
    """The residual of ``signal`` against each variable, the one that explains most first; empty where there is none."""
    stretches = [_finite(stretch) for stretch in stretches]
    residual = np.concatenate([stretch.residual for stretch in stretches]) if stretches else np.zeros(0)
    if len(residual) < 10 * _BINS or not np.any(residual):
        return []
    speed = np.concatenate([stretch.speed for stretch in stretches])
    direction = np.where(np.abs(speed) < _STANDSTILL, 0.0, np.sign(speed))
    variables = (
        ("speed", "rad/s", speed, _speed_edges(speed)),
        ("direction", "", direction, np.array([-1.5, -0.5, 0.5, 1.5])),
        ("output_position", "rad", *_even([stretch.output_position for stretch in stretches])),
        ("time", "s", *_even([stretch.time for stretch in stretches])),
    )
    found = []
    for name, variable_unit, values, edges in variables:
        dependence = _binned(signal, unit, residual, name, variable_unit, values, edges)
        if dependence is not None:
            found.append(dependence)
    by_order = _by_order(signal, unit, stretches)
    if by_order is not None:
        found.append(by_order)
    return sorted(found, key=lambda dependence: -dependence.share)


def _finite(stretch: Stretch) -> Stretch:
    good = np.isfinite(stretch.residual) & np.isfinite(stretch.speed)
    if good.all():
        return stretch
    return Stretch(*(getattr(stretch, name)[good] for name in Stretch.__dataclass_fields__))


def _speed_edges(speed: np.ndarray) -> np.ndarray:
    """Bins that are narrow at low speed, where friction changes, and symmetric, so that directions compare."""
    usual = float(np.quantile(np.abs(speed), 0.995)) or 1.0
    edges = usual * np.array(_SPEED_SHARES)
    edges[-1] = max(np.nextafter(float(np.abs(speed).max()), np.inf), edges[-1])
    return np.concatenate([-edges[:0:-1], edges])


def _even(parts: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    values = np.concatenate(parts)
    lower, upper = float(values.min()), float(values.max())
    return values, np.linspace(lower, np.nextafter(upper, np.inf) if upper > lower else lower, _BINS + 1)


def _binned(
    signal: str,
    unit: str,
    residual: np.ndarray,
    variable: str,
    variable_unit: str,
    values: np.ndarray,
    edges: np.ndarray,
) -> Dependence | None:
    place = np.digitize(values, edges) - 1
    count = np.bincount(place, minlength=len(edges) - 1).astype(float)
    used = count >= 10
    if used.sum() < 2:
        return None
    mean = np.bincount(place, residual, len(count)) / np.maximum(count, 1.0)
    square = np.bincount(place, residual**2, len(count))
    total = square.sum()
    inside = (square - count * mean**2)[used].sum() + square[~used].sum()
    samples = len(residual)
    share = 1.0 - inside / total * samples / max(1.0, samples - used.sum())
    profile = np.sqrt(square / np.maximum(count, 1.0))
    worst = int(np.argmax(np.where(used, profile, -1.0)))
    elsewhere = math.sqrt((total - square[worst]) / max(1.0, samples - count[worst]))
    there = float(profile[worst])
    lowest, highest = (
        int(pick(np.where(used, mean, fill))) for pick, fill in ((np.argmin, np.inf), (np.argmax, -np.inf))
    )
    places = [_in_words(variable, variable_unit, edges, k) for k in (worst, lowest, highest)]
    return Dependence(
        signal, unit, variable, max(0.0, float(share)), float(edges[worst]), float(edges[worst + 1]), variable_unit,
        there, elsewhere, tuple(profile.tolist()), places[0],
        ((float(mean[lowest]), places[1]), (float(mean[highest]), places[2])),
    )  # fmt: skip


def _in_words(variable: str, unit: str, edges: np.ndarray, place: int) -> str:
    if variable == "direction":
        return ("moving backward", "near standstill and at reversals", "moving forward")[place]
    name = {"speed": "at", "output_position": "at an output position of", "time": "at"}[variable]
    of = " of the motor shaft" if variable == "speed" else ""
    return f"{name} {edges[place]:.3g} to {edges[place + 1]:.3g} {unit}{of}"


def _by_order(signal: str, unit: str, stretches: Sequence[Stretch]) -> Dependence | None:
    """The order (cycles per motor revolution) that carries most of the residual's power."""
    orders = np.arange(_LOWEST_ORDER, _HIGHEST_ORDER, _ORDER_STEP)
    power = np.zeros_like(orders)
    total = sum(float(stretch.residual @ stretch.residual) for stretch in stretches)
    for stretch in stretches:
        # at standstill one angle would gather all samples, which looks like every order at once
        moving = np.abs(stretch.speed) > _STANDSTILL
        residual = stretch.residual[moving]
        if len(residual) < 10 * _BINS:
            continue
        place = np.floor(stretch.motor_angle[moving] * (_ANGLE_BINS / (2.0 * math.pi))).astype(np.int64)
        place -= place.min()
        bins = int(place.max()) + 1
        revolutions = bins / _ANGLE_BINS
        if revolutions * _HIGHEST_ORDER < _FEWEST_CYCLES or bins > 1 << 22:
            continue
        # removing the bins' overall mean keeps a constant error from leaking into low orders
        summed = np.bincount(place, residual - residual.mean(), bins)
        length = 1 << max(12, (4 * bins - 1).bit_length())
        spectrum = np.abs(np.fft.rfft(summed, length)) ** 2 * 2.0 / len(residual)
        here = np.interp(orders, np.arange(len(spectrum)) * _ANGLE_BINS / length, spectrum)
        power += np.where(orders * revolutions >= _FEWEST_CYCLES, here, 0.0)
    if not power.any():
        return None
    best = int(np.argmax(power))
    samples = sum(len(stretch.residual) for stretch in stretches)
    share = min(1.0, float(power[best]) / total)
    amplitude = math.sqrt(2.0 * power[best] / samples)
    bands = [float(np.sqrt(band.max() / samples)) for band in np.array_split(power, _BINS)]
    return Dependence(
        signal, unit, "order", share, float(orders[best]), float(orders[best]), "cycles/rev",
        amplitude / math.sqrt(2.0), math.sqrt(max(0.0, total - float(power[best])) / samples), tuple(bands),
        f"{orders[best]:.3g} times per motor revolution", None,
    )  # fmt: skip

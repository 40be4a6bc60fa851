"""Where a model fails: the residual against speed, direction, output position, time and order, the worst in words.

For each variable the residual is averaged within bins. The variable's share is the part of the residual's power that
the bin means explain, beyond a constant and adjusted for their number: 0 for noise, 1 for an error that is a function
of this variable alone.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from ema_bench_replay.long_columns import by_pieces, extremes, joined, mean_of, pieces, quantile
from ema_bench_replay.units import unit_in

from ..criteria import SMALL, STANDSTILL
from ..quantities import quantity, signal_words
from .orders import Periodicity, find_order

_BINS = 16
FEWEST = 10  # samples that a bin needs
_SPEED_SHARES = (0.0, 0.02, 0.05, 0.1, 0.2, 0.35, 0.55, 0.8, 1.0)  # of the usual top speed

FEWEST_SAMPLES = FEWEST * _BINS
"""With fewer samples it cannot be determined where a model fails."""


@dataclass(frozen=True)
class Stretch:
    """Data of one recording, float64 (n,) each: the residual, and the variables it may depend on."""

    residual: np.ndarray  # in the signal's SI unit
    speed: np.ndarray  # rad/s, fast shaft
    motor_angle: np.ndarray  # rad, fast shaft, counter angle
    output_position: np.ndarray  # rad, slow shaft, counter angle
    time: np.ndarray  # s


@dataclass(frozen=True)
class Dependence:
    """How a signal's residual depends on one variable, with the place where it is largest.

    ``share`` is the part of its power that a function of that variable alone explains. ``profile`` is the RMSE per bin,
    from the variable's lowest value to its highest. ``means`` are the lowest and highest bin mean with their places; an
    order has ``periodicity`` instead. ``torque`` [N m per unit of the signal] converts an amplitude to torque, where
    applicable. For an order, ``rmse_there`` is the periodic part and ``rmse_elsewhere`` the rest; for a constant, both
    are the total.
    """

    signal: str
    unit: str
    variable: str
    share: float
    lower: float
    upper: float
    variable_unit: str
    rmse_there: float
    rmse_elsewhere: float
    profile: tuple[float, ...]
    place: str
    means: tuple[tuple[float, str], tuple[float, str]] | None = None
    periodicity: Periodicity | None = None
    torque: float | None = None

    @property
    def is_largest_there(self) -> bool:
        """Whether the error is larger at ``place`` than elsewhere: an order and a constant have no place."""
        return self.variable not in ("order", "constant") and self.rmse_there > self.rmse_elsewhere

    @property
    def where(self) -> str:
        """The place where the error is largest; for an order or a constant, how much of the error it is."""
        there = quantity(self.rmse_there, self.unit)
        if self.variable == "order":
            return f"{there} of it repeat {self.place}"
        if self.variable == "constant":
            return f"{quantity(self._mean, self.unit)} everywhere, on average"
        return self.place if self.is_largest_there else "about the same everywhere"

    @property
    def _mean(self) -> float:
        return self.means[0][0] if self.means else math.nan

    def sentence(self) -> str:
        """The dependence in words."""
        signal = signal_words(self.signal, self.unit)
        if self.share < SMALL:
            where = f"; {self.where}"
            if self.is_largest_there:
                there, elsewhere = quantity(self.rmse_there, self.unit), quantity(self.rmse_elsewhere, self.unit)
                where = f"; it is largest {self.place}: {there} there, {elsewhere} elsewhere"
            percent = round(100.0 * self.share)
            if not percent:
                return f"The error of the {signal} depends on neither speed, direction, position nor time alone{where}."
            most = {"order": "repetition with the motor's angle", "constant": "constant offset"}
            return (
                f"Neither speed, direction, position nor time alone explains much of the error of the {signal} "
                f"({most.get(self.variable, self.variable.replace('_', ' '))} {percent} % of its power){where}."
            )
        share = f"{100.0 * self.share:.0f} % of its power"
        if self.periodicity is not None:
            found = self.periodicity
            torque = f" ({quantity(found.amplitude * self.torque, 'N m')})" if self.torque else ""
            kind: dict[bool | None, str] = {
                True: "; it flips with the direction (dissipative)",
                False: "; in both directions alike (conservative)",
            }
            amplitude = quantity(found.amplitude, self.unit)
            return (
                f"The error of the {signal} repeats {self.place} ({share}): amplitude {amplitude}{torque}, "
                f"phase {found.phase:.2f} rad at the motor counter's zero{kind.get(found.dissipative, '')}."
            )
        (low, low_place), (high, high_place) = self.means or ((math.nan, ""), (math.nan, ""))
        if self.variable == "constant":
            return f"The error of the {signal} is a constant offset of {quantity(high, self.unit)} ({share})."
        return (
            f"The error of the {signal} depends on {self.variable.replace('_', ' ')} ({share}): on average "
            f"{quantity(low, self.unit)} {low_place}, {quantity(high, self.unit)} {high_place}."
        )

    def as_json(self) -> dict[str, object]:
        """For ``compare --json``."""
        content: dict[str, object] = {
            "signal": self.signal,
            "variable": self.variable,
            "share": self.share,
            "at": {"from": self.lower, "to": self.upper, "unit": self.variable_unit},
            "rmse_there": self.rmse_there,
            "rmse_elsewhere": self.rmse_elsewhere,
            "unit": self.unit,
            "profile": list(self.profile),
            "text": self.sentence(),
        }
        if self.periodicity is not None:
            found = self.periodicity
            content |= {"order": found.order, "amplitude": found.amplitude, "phase": found.phase}
            content["dissipative"] = found.dissipative
        return content


def find_dependences(
    signal: str,
    unit: str,
    stretches: Sequence[Stretch],
    torque: float | None = None,
    *,
    motion: str = "rotary",
    standstill: float = STANDSTILL,
    direct: bool = False,
) -> list[Dependence]:
    """The residual of ``signal`` against each variable, the main dependence first; empty if there is too little data.

    If several variables explain nearly the same, the simplest comes first: an error that depends on direction is also a
    function of speed. ``torque`` is the N m per unit of the signal, if applicable. ``motion`` is ``linear`` for a
    linear machine, ``direct`` is True if the output turns with the motor; ``standstill`` [rad/s or m/s] is the speed
    below which a direction means little. Only orders with at least two samples a cycle are named.
    """
    stretches = [_finite(stretch) for stretch in stretches]
    residual = joined([stretch.residual for stretch in stretches]) if stretches else np.zeros(0)
    if len(residual) < FEWEST_SAMPLES or not any(np.any(residual[rows]) for rows in pieces(len(residual))):
        return []
    speed = joined([stretch.speed for stretch in stretches])
    direction = by_pieces(lambda part: np.where(np.abs(part) < standstill, 0.0, np.sign(part)), speed)
    variables = (
        ("direction", "", direction, np.array([-1.5, -0.5, 0.5, 1.5])),
        ("speed", unit_in("rad/s", motion), speed, _speed_edges(speed)),
        ("output_position", unit_in("rad", motion), *_even([stretch.output_position for stretch in stretches])),
        ("time", "s", *_even([stretch.time for stretch in stretches])),
    )
    found = [_constant(signal, unit, residual)]
    found += [d for v in variables if (d := _binned(signal, unit, residual, *v, direct=direct)) is not None]
    # a carriage has no revolutions
    turns = motion == "rotary"
    periodic = _periodic(signal, unit, residual, stretches, torque, standstill) if turns else None
    if periodic is not None:
        found.insert(1, periodic)
    best = max(dependence.share for dependence in found)
    simplest = next(dependence for dependence in found if dependence.share >= (1.0 - SMALL) * best)
    others = sorted((d for d in found if d is not simplest), key=lambda dependence: -dependence.share)
    return [simplest, *others]


def _finite(stretch: Stretch) -> Stretch:
    columns = [getattr(stretch, name) for name in Stretch.__dataclass_fields__]
    if all(np.isfinite(column[rows]).all() for rows in pieces(len(stretch.residual)) for column in columns):
        return stretch
    return Stretch(*(by_pieces(_where_all_finite, column, *columns) for column in columns))


def _where_all_finite(values: np.ndarray, *columns: np.ndarray) -> np.ndarray:
    return values[np.all(np.isfinite(columns), axis=0)]


def _speed_edges(speed: np.ndarray) -> np.ndarray:
    """Bins that are narrow at low speed, where friction changes, and symmetric, so that directions compare."""
    usual = quantile(lambda: (np.abs(speed[rows]) for rows in pieces(len(speed))), 0.995) or 1.0
    edges = usual * np.array(_SPEED_SHARES)
    edges[-1] = max(np.nextafter(max(map(abs, extremes(speed))), np.inf), edges[-1])
    return np.concatenate([-edges[:0:-1], edges])


def _even(parts: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    values = joined(parts)
    lower, upper = extremes(values)
    return values, np.linspace(lower, np.nextafter(upper, np.inf) if upper > lower else lower, _BINS + 1)


def _binned(
    signal: str,
    unit: str,
    residual: np.ndarray,
    variable: str,
    variable_unit: str,
    values: np.ndarray,
    edges: np.ndarray,
    *,
    direct: bool,
) -> Dependence | None:
    if not edges[0] < edges[-1]:
        return None  # the variable never changes
    count, sums, square = np.zeros((3, len(edges) - 1))
    for rows in pieces(len(residual)):
        place = np.digitize(values[rows], edges) - 1
        count += np.bincount(place, minlength=len(count))
        sums += np.bincount(place, residual[rows], len(count))
        square += np.bincount(place, residual[rows] ** 2, len(count))
    used = count >= FEWEST
    if used.sum() < 2:
        return None
    mean = sums / np.maximum(count, 1.0)
    total = square.sum()
    inside = (square - count * mean**2)[used].sum() + square[~used].sum()
    samples = len(residual)
    # beyond what a constant explains, and adjusted for the number of bins
    explained = total - samples * mean_of(residual) ** 2 - inside * samples / max(1.0, samples - used.sum())
    share = explained / total
    profile = np.sqrt(square / np.maximum(count, 1.0))
    worst = int(np.argmax(np.where(used, profile, -1.0)))
    elsewhere = math.sqrt((total - square[worst]) / max(1.0, samples - count[worst]))
    there = float(profile[worst])
    lowest, highest = (
        int(pick(np.where(used, mean, fill))) for pick, fill in ((np.argmin, np.inf), (np.argmax, -np.inf))
    )
    places = [_in_words(variable, variable_unit, edges, k, direct=direct) for k in (worst, lowest, highest)]
    means = ((float(mean[lowest]), places[1]), (float(mean[highest]), places[2]))
    return Dependence(
        signal, unit, variable, max(0.0, float(share)), float(edges[worst]), float(edges[worst + 1]), variable_unit,
        there, elsewhere, tuple(profile.tolist()), places[0], means,
    )  # fmt: skip


def _in_words(variable: str, unit: str, edges: np.ndarray, place: int, *, direct: bool) -> str:
    if variable == "direction":
        return ("moving backward", "near standstill and at reversals", "moving forward")[place]
    name = {"speed": "at", "output_position": "at an output position of", "time": "at"}[variable]
    of = " of the motor shaft" if variable == "speed" and unit == "rad/s" and not direct else ""
    return f"{name} {edges[place]:.3g} to {edges[place + 1]:.3g} {unit}{of}"


def _times_per_revolution(order: float) -> str:
    times = f"{order:.3g}"
    return "once per motor revolution" if times == "1" else f"{times} times per motor revolution"


def _constant(signal: str, unit: str, residual: np.ndarray) -> Dependence:
    mean, rmse = float(mean_of(residual)), math.sqrt(_mean_square(residual))
    place = ((mean, "everywhere"), (mean, "everywhere"))
    return Dependence(signal, unit, "constant", mean**2 / rmse**2, 0.0, 0.0, "", rmse, rmse, (), "everywhere", place)


def _mean_square(values: np.ndarray) -> float:
    return float(sum(np.sum(values[rows] ** 2) for rows in pieces(len(values))) / len(values))


def _where_moving(standstill: float, values: np.ndarray, speed: np.ndarray) -> np.ndarray:
    return values[np.abs(speed) > standstill]


def _periodic(
    signal: str, unit: str, residual: np.ndarray, stretches: Sequence[Stretch], torque: float | None, standstill: float
) -> Dependence | None:
    """The order (cycles per motor revolution) that contains most of the residual's power."""
    parts = []
    for stretch in stretches:
        # at standstill one angle would collect all samples, which looks like every order at once
        moves = partial(_where_moving, standstill)
        residual_there, angle, speed = (
            by_pieces(moves, values, stretch.speed) for values in (stretch.residual, stretch.motor_angle, stretch.speed)
        )
        parts.append((residual_there, angle, by_pieces(np.sign, speed)))
    found = find_order(parts, resolved=True)
    if found is None:
        return None
    power = found.amplitude**2 / 2.0
    total = _mean_square(residual)
    moving_share = sum(len(part[0]) for part in parts) / len(residual)
    return Dependence(
        signal, unit, "order", min(1.0, power * moving_share / total), found.order, found.order, "cycles/rev",
        math.sqrt(power), math.sqrt(max(0.0, total - power * moving_share)),
        tuple(float(band.max()) for band in np.array_split(found.spectrum, _BINS)),
        _times_per_revolution(found.order), periodicity=found, torque=torque,
    )  # fmt: skip

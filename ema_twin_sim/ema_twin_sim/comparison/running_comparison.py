"""Residuals of a twin against its bench, with running statistics; used by the live monitor and offline."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from typing import TypedDict

import numpy as np

from ema_bench_replay.long_columns import by_pieces, pieces, times

from ..criteria import NOISY
from ..model import Model
from ..simulation.compared_signals import ALL_UNITS, UNITS, driving, noise_floors
from .beyond_noise import told_share
from .independent_rows import independent_rows


class SignalError(TypedDict):
    """Error of a twin in one signal, SI; as ``compare --json`` writes it."""

    rmse: float
    relative: float  # norm of the residual over norm of the measured signal
    noise_floor: float
    unit: str
    driven: bool  # the signal is the twin's input, so its residual means nothing


def excess_removed(before: SignalError, after: SignalError) -> float | None:
    """Share (0 to 1) of the excess (power above the noise floor) that a model removes; None if there is none."""
    share = share_removed(before["rmse"], after["rmse"], before["noise_floor"])
    return None if share is None else told_share(share)


def share_removed(before: float, after: float, noise_floor: float) -> float | None:
    """Share of an RMSE's power above its noise floor that is removed; all of it if the floor is reached, never more.

    None if there was nothing above the floor, or if an error is not known (NaN).
    """
    excess = before**2 - noise_floor**2
    share = (before**2 - max(after, noise_floor) ** 2) / excess if excess > 0.0 else math.nan
    return None if math.isnan(share) or math.isnan(after) else share


class RunningComparison:
    """Root-mean-square residuals of the compared signals, over the run and over the last ``window`` seconds.

    Samples come one by one (``add``) or as arrays (``add_rows``); a sample that is NaN on either side does not count
    for that signal. The window is counted in samples of ``period`` [s], by default the model's; if samples come with
    times, these are used.

    ``noise`` is the noise floor if it is known for the recordings (``measured.noise.noise_of``), else the model's.
    """

    def __init__(
        self,
        model: Model,
        source: str,
        window: float = 5.0,
        period: float | None = None,
        noise: Mapping[str, float] | None = None,
    ) -> None:
        self.source = source
        self._period = period or model.value("sensors.sample_period")
        self.samples = 0
        self._model = model
        self._torque_constant = model.value("machine.torque_constant")
        self._square = dict.fromkeys(ALL_UNITS, 0.0)
        self._measured_square = dict.fromkeys(ALL_UNITS, 0.0)
        self._count = dict.fromkeys(ALL_UNITS, 0)
        self._independent = dict.fromkeys(ALL_UNITS, 0.0)
        self._window: dict[str, deque[float]] = {
            name: deque(maxlen=max(1, round(window / self._period))) for name in ALL_UNITS
        }
        self._width = window
        self._times: dict[str, deque[float]] = {name: deque() for name in ALL_UNITS}
        self._has_speed = False
        self._noise = noise
        self._floors: dict[bool, dict[str, float]] = {}

    def add(self, bench: Mapping[str, float], twin: Mapping[str, float], time: float | None = None) -> dict[str, float]:
        """Add a pair of samples, at an increasing ``time`` [s]; return its residuals, NaN if a value is missing."""
        self.samples += 1
        residuals = {}
        for name in UNITS:
            residual, measured = self._pair(name, bench, twin)
            residuals[name] = residual
            if residual == residual and measured == measured:
                self._count[name] += 1
                self._square[name] += residual * residual
                self._measured_square[name] += measured * measured
                self._window[name].append(residual * residual)
                if time is not None:
                    self._forget(name, time)
                self._has_speed = self._has_speed or name == "speed"
        return residuals

    def _forget(self, name: str, time: float) -> None:
        """Store the time of the newest sample and drop samples older than the window."""
        squares, times = self._window[name], self._times[name]
        if squares.maxlen is not None:
            squares = self._window[name] = deque(squares)
        times.append(time)
        while times[0] <= time - self._width:
            times.popleft()
            squares.popleft()

    def _pair(self, name: str, bench: Mapping[str, float], twin: Mapping[str, float]) -> tuple[float, float]:
        if name == "unexplained_torque":
            return twin.get(name, math.nan), bench.get("current", math.nan) * self._torque_constant
        measured = bench.get(name, math.nan)
        return measured - twin.get(name, math.nan), measured

    def add_rows(self, bench: Mapping[str, np.ndarray], twin: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """Add whole recordings, signals float64 (n,) by name, and return the residuals (n,) of those that both have."""
        residuals = {}
        count = 0
        for name in ALL_UNITS:
            if name not in twin or (name not in bench and name != "unexplained_torque"):
                continue
            if name == "unexplained_torque":
                residual, measured = twin[name], times(bench["current"], self._torque_constant)
            else:
                residual, measured = by_pieces(np.subtract, bench[name], twin[name]), bench[name]
            residuals[name] = residual
            count = len(residual)
            if not all(_both_known(residual[rows], measured[rows]).all() for rows in pieces(count)):
                pair = residual, measured
                residual, measured = by_pieces(_first_known, *pair), by_pieces(_first_known, *reversed(pair))
            self._count[name] += len(residual)
            self._independent[name] += independent_rows(residual)
            for rows in pieces(len(residual)):
                self._square[name] += float(residual[rows] @ residual[rows])
                self._measured_square[name] += float(measured[rows] @ measured[rows])
            self._window[name].extend((residual[-(self._window[name].maxlen or len(residual)) :] ** 2).tolist())
            self._has_speed = self._has_speed or (name == "speed" and len(residual) > 0)
        self.samples += count
        return residuals

    def include(self, other: RunningComparison) -> None:
        """Pool the sums of another comparison into this one (its window is not changed).

        A signal that is an input of the other twin but not of this one is left out: its residual of zero means nothing.
        """
        self.samples += other.samples
        self._has_speed = self._has_speed or other._has_speed
        for name in ALL_UNITS:
            if other.source != self.source and name in driving(other.source):
                continue
            self._count[name] += other._count[name]
            self._independent[name] += other._independent[name]
            self._square[name] += other._square[name]
            self._measured_square[name] += other._measured_square[name]

    @property
    def independent(self) -> dict[str, float]:
        """By signal: effective number of independent values in the residuals that came as arrays."""
        return dict(self._independent)

    @property
    def rmse(self) -> dict[str, float]:
        """RMSE over the run per signal, NaN if nothing was compared."""
        return {n: math.sqrt(self._square[n] / self._count[n]) if self._count[n] else math.nan for n in ALL_UNITS}

    @property
    def rmse_window(self) -> dict[str, float]:
        """RMSE over the last window per signal, NaN if nothing was compared."""
        return {n: math.sqrt(math.fsum(w) / len(w)) if w else math.nan for n, w in self._window.items()}

    @property
    def noise_floor(self) -> dict[str, float]:
        """The sensors' noise per signal, standard deviation."""
        if self._noise is not None:
            return dict(self._noise)
        if self._has_speed not in self._floors:
            self._floors[self._has_speed] = noise_floors(self._model, has_speed=self._has_speed, period=self._period)
        return self._floors[self._has_speed]

    @property
    def beyond_noise(self) -> dict[str, float]:
        """Ratio of error to sensor noise in the last window for each signal that exceeds its noise, worst first."""
        floor, left_out = self.noise_floor, {*driving(self.source)}
        if self.source != "current":  # the current contains the information of the unexplained torque
            left_out.add("unexplained_torque")
        times = {n: rmse / floor[n] for n, rmse in self.rmse_window.items() if n not in left_out and floor[n] > 0.0}
        over = {name: value for name, value in times.items() if value > NOISY}
        return dict(sorted(over.items(), key=lambda item: -item[1]))

    def result(self) -> dict[str, SignalError]:
        """Per compared signal ``{rmse, relative, noise_floor, unit, driven}``; absent signals are left out.

        ``relative`` is the norm of the residual over the norm of the measured signal (for the unexplained torque, of
        the measured motor torque).
        """
        found: dict[str, SignalError] = {}
        for name, rmse in self.rmse.items():
            if math.isnan(rmse):
                continue
            norm = math.sqrt(self._measured_square[name])
            found[name] = {
                "rmse": rmse,
                "relative": math.sqrt(self._square[name]) / norm if norm > 0.0 else 0.0,
                "noise_floor": self.noise_floor[name],
                "unit": ALL_UNITS[name],
                "driven": name in driving(self.source),
            }
        return found


def _both_known(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return ~(np.isnan(one) | np.isnan(other))


def _first_known(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """The values (m,) of ``one`` where both are known."""
    return one[_both_known(one, other)]

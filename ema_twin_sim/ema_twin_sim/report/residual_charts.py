"""Charts of the residuals of each model against speed, output position, direction and order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..comparison.binning import bin_edges, quartiles, rows_by_bin
from ..comparison.orders import ORDERS, Periodicity, find_order
from ..comparison.where import FEWEST_SAMPLES, Stretch
from ..model import Model
from ..quantities import axis_unit
from .axis_limits import hides_the_rest, limit_words, range_beside
from .chart import FAINT, MODELS, Chart, Trace, axis, band, label, line, log_axis, noise_band, widths
from .content import Shown

_BINS = 30
_FEWEST = 5  # minimum number of samples of a bin
_BANDS = 240  # number of bands of a spectrum
_LEAST_SHOWN = 10.0  # orders that a spectrum shows at least
_BEYOND = 1.6  # highest order shown, times the highest that the model names
_NEAR = 0.03  # orders; a peak this near to a named order is that order's
_APART = 0.09  # decades; numbers above a spectrum that are nearer are put together
_HEIGHT = 300  # pixels
_SYMBOLS = dict(zip(MODELS, ("circle", "square", "diamond"), strict=True))


@dataclass(frozen=True)
class Orders:
    """The order spectra of all models, and their amplitudes at each order that the machine's file names."""

    chart: Chart
    named: tuple[tuple[float, str, tuple[float, ...]], ...]  # order, its name, amplitudes by model
    unit: str  # of the amplitudes
    scale: float  # divisor of the amplitudes in the chart


@dataclass(frozen=True)
class Failures:
    """One signal's residual: charts against speed, position and direction, and its orders if anything turns."""

    signal: str
    words: str  # the signal as people call it
    charts: tuple[Chart, ...]
    orders: Orders | None


def failures(given: Shown, model: Model, names: Sequence[str], *, limited: bool = False) -> list[Failures]:
    """Where models fail, for each main signal; ``model`` names the orders, ``names`` are those of all models.

    ``limited``: whether axes leave out the errors of the first ``model`` where these would hide those of the others.
    Empty if the recordings are too short.
    """
    found = []
    for name in given.headlines:
        stretches = [[each.stretches[name] for each in curves if name in each.stretches] for curves in given.curves]
        if sum(len(part.residual) for part in stretches[0]) < FEWEST_SAMPLES:
            continue
        narrow = limited and hides_the_rest(given, model, name)
        geared = model.motion == "rotary" and not model.is_direct
        shown = _Signal(name, given, names, stretches, limited=narrow, geared=geared)
        orders = shown.over_order(model) if model.motion == "rotary" else None
        found.append(
            Failures(name, shown.words, (shown.over_speed(), shown.over_position(), shown.over_direction()), orders)
        )
    return found


def named_orders(model: Model) -> list[tuple[float, str]]:
    """The orders that the machine's file names and the spectra cover, with their names, lowest first."""
    return sorted((order, name) for name, order in model.orders.items() if ORDERS[0] <= order <= ORDERS[-1])


class _Signal:
    """One signal's residuals of all models."""

    def __init__(
        self,
        name: str,
        given: Shown,
        models: Sequence[str],
        stretches: Sequence[Sequence[Stretch]],
        *,
        limited: bool,
        geared: bool,
    ) -> None:
        """``geared``: whether the output has another speed than the motor."""
        error, first = given.comparisons[0].overall[name], given.curves[0][0]
        self.words, self.models, self.base = given.words(name), models, error["unit"]
        self.roles = MODELS[: len(models)]
        self.widths = dict(zip(MODELS, widths(len(models)), strict=False))
        self.way, self.still = first.way, first.still
        self.stretches = stretches
        self.residuals = [np.concatenate([part.residual for part in parts]) for parts in stretches]
        self.speeds = [np.concatenate([part.speed for part in parts]) for parts in stretches]
        self.limited = limited
        self.geared = geared
        told = self.residuals[1:] if limited else self.residuals
        self.scale, self.unit = axis_unit(max(float(np.nanquantile(np.abs(r), 0.98)) for r in told), self.base)
        self.title = f"residual of the {self.words} [{self.unit}]"
        self.floor = error["noise_floor"] / self.scale
        self.band = noise_band(self.floor)

    def over_speed(self) -> Chart:
        """The residual over the motor's speed, both directions."""
        traces = [
            trace
            for role, model, speed, residual in zip(self.roles, self.models, self.speeds, self.residuals, strict=True)
            for trace in self._banded(speed, residual, role, model, narrow=True)
        ]
        whose, of = ("the motor's", " of the motor") if self.geared else ("the", "")
        return self._chart(f"{whose} speed", axis(f"speed{of} [{self.way}/s]"), traces)

    def over_position(self) -> Chart:
        """The residual over the output's position, separately forward and backward."""
        traces: list[Trace] = []
        for role, model, parts, speed, residual in zip(
            self.roles, self.models, self.stretches, self.speeds, self.residuals, strict=True
        ):
            position = np.concatenate([part.output_position for part in parts])
            for sense, said, dash in ((1.0, "forward", "solid"), (-1.0, "backward", "dot")):
                chosen = sense * speed > self.still
                traces += self._banded(position[chosen], residual[chosen], role, f"{model}, {said}", dash=dash)
        return self._chart(
            "the output's position, forward solid, backward dotted",
            axis(f"position of the output [{self.way}]"),
            traces,
        )

    def over_direction(self) -> Chart:
        """The residual moving backward, near standstill, and moving forward."""
        traces: list[Trace] = []
        for role, model, speed, residual in zip(self.roles, self.models, self.speeds, self.residuals, strict=True):
            groups = {
                "backward": speed < -self.still,
                "standstill": np.abs(speed) <= self.still,
                "forward": speed > self.still,
            }
            told = {
                said: np.nanquantile(residual[chosen], (0.25, 0.5, 0.75)) / self.scale
                for said, chosen in groups.items()
                if np.isfinite(residual[chosen]).sum() >= _FEWEST
            }
            lower, median, upper = np.array(list(told.values())).reshape(-1, 3).T
            quarters = {"array": upper - median, "arrayminus": median - lower}
            spread = {"type": "data", "symmetric": False, **quarters, "color": role, "thickness": 2, "width": 7}
            marker = {"color": role, "size": 10 if self.widths[role] >= 1.0 else 6, "symbol": _SYMBOLS[role]}
            traces.append(
                {"type": "scatter", "mode": "markers", "x": list(told), "y": median, "name": label(model)}
                | {"error_y": spread, "marker": marker}
            )
        return self._chart("the direction of motion", axis("direction", type="category"), traces)

    def over_order(self, model: Model) -> Orders | None:
        """The order spectra; None if nothing turns enough."""
        first = find_order(_moving(self.stretches[0], self.still))
        if first is None:
            return None
        flips = bool(first.dissipative)
        spectra = [find_order(_moving(parts, self.still, flips=flips)) for parts in self.stretches]
        if any(found is None for found in spectra):
            return None
        lines = [found.spectrum for found in spectra if isinstance(found, Periodicity)]
        highest = min(float(ORDERS[-1]), max(_LEAST_SHOWN, _BEYOND * max(model.orders.values(), default=100.0)))
        place = np.searchsorted(np.geomspace(ORDERS[0], highest, _BANDS), ORDERS[highest >= ORDERS])
        bands = [np.flatnonzero(place == k) for k in np.unique(place)]
        peaks = [np.array([values[band].max() for band in bands]) for values in lines]
        told = peaks[1:] if self.limited else peaks
        scale, unit = axis_unit(max(float(values.max()) for values in told), self.base)
        at = [np.array([ORDERS[band[values[band].argmax()]] for band in bands]) for values in lines]
        traces = [
            line(x, values / scale, name, role, width=1.6 * self.widths[role])
            for x, values, name, role in zip(at, peaks, self.models, self.roles, strict=True)
        ]
        named = named_orders(model)
        marks, numbers = _marked([order for order, _ in named])
        kind = "; assumed to oppose the motion" if flips else ""
        above = {"range": [0.0, range_beside(traces)["range"][1]]} if self.limited else {}
        layout = {
            "xaxis": log_axis("order [cycles per turn of the motor]", ORDERS[highest >= ORDERS]),
            "yaxis": axis(f"amplitude, {self.words} [{unit}]", rangemode="tozero", **above),
            "shapes": marks,
            "annotations": numbers,
            "margin": {"t": 46},  # the numbers, and above them the buttons
        }
        said = f"Residual of the {self.words} against order{kind}; the numbers are in the table of orders below"
        chart = Chart(said + self._limit_words(), _HEIGHT, layout, traces)
        peaks_of = [
            (order, said, tuple(float(values[np.abs(ORDERS - order) <= _NEAR].max()) for values in lines))
            for order, said in named
        ]
        return Orders(chart, tuple(peaks_of), self.base, scale)

    def _banded(
        self, x: np.ndarray, residual: np.ndarray, role: str, name: str, *, narrow: bool = False, dash: str = "solid"
    ) -> list[Trace]:
        """The medians over ``x``, and a band between the quartiles."""
        good = np.isfinite(x) & np.isfinite(residual)
        x, residual = x[good], residual[good] / self.scale
        rows = rows_by_bin(x, bin_edges(x, _BINS, narrow=narrow), _FEWEST)
        if not rows:
            return []
        lower, median, upper = quartiles(residual, rows)
        centres = np.array([np.median(x[found]) for found in rows])
        middle = line(centres, median, name, role, width=2.5 * self.widths[role], dash=dash)
        return [*band(centres, lower, upper, name, role), middle]

    def _chart(self, against: str, x: dict[str, object], traces: list[Trace]) -> Chart:
        said = f"Residual of the {self.words} against {against}{self._limit_words()}"
        limits = range_beside(traces, 2.0 * self.floor) if self.limited else {}
        return Chart(said, _HEIGHT, {"xaxis": x, "yaxis": axis(self.title, **limits), "shapes": [self.band]}, traces)

    def _limit_words(self) -> str:
        return limit_words(self.models[0]) if self.limited else ""


def _moving(
    parts: Sequence[Stretch], still: float, *, flips: bool | None = None
) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Residual, motor angle and direction while the machine moves, as ``find_order`` takes them.

    If ``flips`` is given (whether residuals change sign with the direction), that sign is applied here and the
    direction is set to 1, so that ``find_order`` does not decide about it again.
    """
    found = []
    for part in parts:
        good = np.isfinite(part.residual) & np.isfinite(part.motor_angle) & (np.abs(part.speed) > still)
        residual, sense = part.residual[good], np.sign(part.speed[good])
        if flips is not None:
            residual, sense = residual * (sense if flips else 1.0), np.ones(len(sense))
        found.append((residual, part.motor_angle[good], sense))
    return found


def _marked(orders: Sequence[float]) -> tuple[list[dict[str, object]], list[dict[str, object]]]:
    """A line at each named order, and its number above; numbers that would overlap are put together."""
    lines = [
        {"type": "line", "xref": "x", "yref": "y domain", "x0": order, "x1": order, "y0": 0, "y1": 1, "layer": "below",
         "line": {"color": FAINT, "width": 1, "dash": "dot"}}
        for order in orders
    ]  # fmt: skip
    groups: list[list[int]] = []
    for k, order in enumerate(orders):
        if groups and np.log10(order / orders[groups[-1][-1]]) < _APART:
            groups[-1].append(k)
        else:
            groups.append([k])
    numbers: list[dict[str, object]] = []
    for group in groups:
        text = str(group[0] + 1) if len(group) == 1 else f"{group[0] + 1}–{group[-1] + 1}"
        place = float(np.mean(np.log10([orders[k] for k in group])))
        above = {"xref": "x", "y": 1.0, "yref": "y domain", "yanchor": "bottom", "showarrow": False}
        numbers.append({"text": text, "x": place, **above})
    return lines, numbers

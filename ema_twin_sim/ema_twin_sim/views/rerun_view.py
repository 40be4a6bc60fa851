"""The rerun view: bench and twin over each other, their residuals, and the error against the sensors' noise."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from ema_bench_replay.errors import InputError

from ..comparison.running_comparison import UNITS
from .screen import start_viewer

TIMELINE = "t"
BENCH_COLOUR = [225, 225, 225]
TWIN_COLOUR = [245, 120, 30]
_RESIDUAL_COLOUR = [80, 170, 240]
_LEVEL_COLOURS = {"current": [80, 170, 240], "speed": [90, 200, 120], "output_position": [235, 90, 110]}

SHOWN = ("output_position", "current", "speed")
"""Signals drawn bench over twin, each beside its residual."""
_VIEWER_PORT = 9876
_WINDOW = 1.0  # s, of the RMSE that falls when an effect is added


class RerunView:
    """A rerun recording (``path``), shown in a viewer too where ``viewer``; takes samples in batches, live or whole."""

    def __init__(
        self, path: Path | None, title: str, noise_floor: Mapping[str, float], *, viewer: bool = False
    ) -> None:
        """Raises InputError where the file cannot be written."""
        self._noise = noise_floor
        self._window: dict[str, deque[tuple[float, float]]] = {name: deque() for name in SHOWN}
        self._sums = dict.fromkeys(SHOWN, 0.0)
        self._stream = rr.RecordingStream(title, send_properties=False)
        sinks: list[Any] = []
        if path is not None:
            try:
                path.open("wb").close()
            except OSError as error:
                raise InputError(f"{path}: cannot be written ({error.strerror}); choose another folder") from None
            sinks.append(rr.FileSink(str(path)))
        if viewer:
            start_viewer("--port", str(_VIEWER_PORT), "--bind", "127.0.0.1", "--hide-welcome-screen")
            sinks.append(rr.GrpcSink(f"rerun+http://127.0.0.1:{_VIEWER_PORT}/proxy"))
        if sinks:
            self._stream.set_sinks(*sinks, default_blueprint=_blueprint())
        self._style()

    def _style(self) -> None:
        for name in SHOWN:
            unit = UNITS[name]
            self._line(f"{name}/bench", BENCH_COLOUR, f"bench [{unit}]", 2.0)
            self._line(f"{name}/twin", TWIN_COLOUR, f"twin [{unit}]", 1.5)
            self._line(f"residual/{name}", _RESIDUAL_COLOUR, f"measured - twin [m{unit}]", 1.0)
            self._line(f"error/{name}", _LEVEL_COLOURS[name], name.replace("_", " "), 2.0)
        self._line("unexplained_torque", _RESIDUAL_COLOUR, "unexplained torque [mN m]", 1.0)

    def _line(self, entity: str, colour: Sequence[int], label: str, width: float) -> None:
        self._stream.log(entity, rr.SeriesLines(colors=[colour], names=[label], widths=[width]), static=True)

    def add(
        self,
        time: Sequence[float],
        bench: Mapping[str, np.ndarray],
        twin: Mapping[str, np.ndarray],
        residuals: Mapping[str, np.ndarray],
    ) -> None:
        """Take a batch: times [s] (n,), signals and residuals (n,) by name in SI units."""
        index = np.asarray(time, np.float64)
        for name in SHOWN:
            if name in bench:
                self._send(f"{name}/bench", index, bench[name])
            if name in twin:
                self._send(f"{name}/twin", index, twin[name])
            if name in residuals:
                self._send(f"residual/{name}", index, np.asarray(residuals[name]) * 1e3)
                self._send(f"error/{name}", index, self._noise_levels(name, index, residuals[name]))
        if "unexplained_torque" in residuals:
            self._send("unexplained_torque", index, np.asarray(residuals["unexplained_torque"]) * 1e3)

    def _send(self, entity: str, index: np.ndarray, values: np.ndarray) -> None:
        values = np.asarray(values, np.float64)
        good = np.isfinite(values)
        if good.any():
            times = [rr.TimeColumn(TIMELINE, duration=index[good])]
            self._stream.send_columns(entity, times, rr.Scalars.columns(scalars=values[good]))

    def _noise_levels(self, name: str, index: np.ndarray, residual: np.ndarray) -> np.ndarray:
        """RMSE over the last second above the sensor's noise floor [dB], per sample."""
        window, levels = self._window[name], np.empty(len(index))
        for k, (time, value) in enumerate(zip(index.tolist(), np.asarray(residual, float).tolist(), strict=True)):
            square = value * value if value == value else 0.0
            window.append((time, square))
            self._sums[name] += square
            while window[0][0] < time - _WINDOW:
                self._sums[name] -= window.popleft()[1]
            power = max(self._sums[name], 0.0) / len(window) / self._noise[name] ** 2
            levels[k] = 10.0 * math.log10(max(power, 1e-3))
        return levels

    def tell(self, time: float, text: str) -> None:
        """A line of the story at a time [s]."""
        self._stream.set_time(TIMELINE, duration=time)
        self._stream.log("story", rr.TextLog(text))
        self._stream.reset_time()

    def close(self) -> None:
        """Write what is held back."""
        self._stream.flush()
        self._stream.disconnect()


def _blueprint() -> rrb.Blueprint:
    titles = {
        "output_position": "output position [rad, slow shaft]",
        "current": "quadrature current [A]",
        "speed": "speed [rad/s, motor shaft]",
    }
    left = [rrb.TimeSeriesView(origin=f"/{name}", name=titles[name]) for name in SHOWN]
    right = [
        rrb.TimeSeriesView(origin="/residual/output_position", name="output position, measured - twin [mrad]"),
        rrb.TimeSeriesView(origin="/residual/current", name="current, measured - twin [mA]"),
        rrb.TimeSeriesView(origin="/error", name="error of the last second above the sensors' noise [dB]"),
    ]
    story = rrb.TextLogView(origin="/story", name="story")
    torque = rrb.TimeSeriesView(origin="/unexplained_torque", name="unexplained torque [mN m, motor shaft]")
    return rrb.Blueprint(
        rrb.Vertical(
            rrb.Horizontal(rrb.Vertical(*left), rrb.Vertical(*right)),
            rrb.Horizontal(torque, story),
            row_shares=[4, 1],
        ),
        collapse_panels=True,
    )

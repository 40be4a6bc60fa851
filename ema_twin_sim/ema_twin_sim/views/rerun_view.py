"""The live view: curves of bench and twin, their residuals with the sensors' noise, the error, and the gear train."""

from __future__ import annotations

import time as clock
from collections.abc import Mapping, Sequence
from itertools import groupby
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from ..model import Model
from ..plant.planetary.geometry import Gearing
from ..quantities import signal_words
from ..simulation.compared_signals import UNITS
from .beside_curves import send_noise, signal_column, style_noise
from .gear_train import log_train, send_motion, train_tab
from .palette import AFTER, BEFORE, GOOD, MEASURED, RIVAL
from .recording_views import layout
from .rms_window import RmsWindow
from .stream import (
    LIVE_APPLICATION,
    TIMELINE,
    begin,
    finish_file,
    finish_viewer,
    open_for_writing,
    path_of,
    send,
    style,
)
from .train_motion import by_ratios, gearing_shown

SHOWN = ("output_position", "current", "speed")
"""Signals that are drawn, bench and twin together, each above its residual."""
ROOT = "live"
_PAUSE = 0.25  # s, minimum interval between two transmissions
_WINDOW = 1.0  # s, window of the RMSE that falls when an effect is added
_LEVEL_COLOURS = {"current": AFTER, "speed": GOOD, "output_position": RIVAL}
_MILLI = 1e3
_LEAST_LEVEL = -30.0  # dB
_PICTURE = 0.04  # s, interval between two pictures of the gear train
_FULL = 0.6  # N m of the motor at which the train's colours are strongest; fixed, since later samples are unknown


_Batch = tuple[np.ndarray, Mapping[str, np.ndarray], Mapping[str, np.ndarray], Mapping[str, np.ndarray]]


class RerunView:
    """A rerun recording into a file (a path) or to a viewer (its address); takes samples in batches, live or whole.

    With a ``model`` whose gearbox is known, the gear train is shown too.

    Attributes:
        into: the file or the viewer.
    """

    def __init__(
        self,
        into: Path | str,
        title: str,
        noise_floor: Mapping[str, float],
        *,
        model: Model | None = None,
        in_browser: bool = False,
    ) -> None:
        """Open the file or connect to the viewer. Raises InputError if the file cannot be written."""
        self.into = into
        self._noise = noise_floor
        self._windows = {name: RmsWindow(_WINDOW) for name in SHOWN}
        self._gearing = gearing_shown(model) if model is not None else None
        self._torque_constant = model.value("machine.torque_constant") if model is not None else 0.0
        self._pictured = -np.inf
        self._held: list[_Batch] = []
        self._sent = -np.inf
        self._stream = rr.RecordingStream(LIVE_APPLICATION, send_properties=False)
        sink = rr.GrpcSink(into) if isinstance(into, str) else open_for_writing(into)
        # a browser receives earlier data in another order, and ignores a layout that is only the default
        begin(self._stream, sink, live_blueprint(self._gearing), active=in_browser)
        self._stream.send_recording_name(title)
        self._style()

    def _style(self) -> None:
        for name in SHOWN:
            unit = UNITS[name]
            style(self._stream, f"{ROOT}/{name}/curves/bench", f"bench [{unit}]", MEASURED, 2.5)
            style(self._stream, f"{ROOT}/{name}/curves/twin", f"twin [{unit}]", BEFORE, 1.5)
            style(self._stream, f"{ROOT}/{name}/residual/twin", f"measured − twin [m{unit}]", BEFORE, 1.2)
            style(self._stream, f"error/{name}", f"{name.replace('_', ' ')} [dB]", _LEVEL_COLOURS[name], 2.0)
            style_noise(self._stream, f"{ROOT}/{name}/residual", f"m{unit}")
        style(self._stream, "unexplained_torque", "unexplained torque [mN m]", AFTER, 1.2)
        if self._gearing is not None:
            log_train(self._stream, self._gearing)

    def add(
        self,
        time: Sequence[float],
        bench: Mapping[str, np.ndarray],
        twin: Mapping[str, np.ndarray],
        residuals: Mapping[str, np.ndarray],
    ) -> None:
        """Take a batch: times [s] (n,), signals and residuals (n,) by name in SI units. It is shown shortly after."""
        self._held.append((np.asarray(time, np.float64), bench, twin, residuals))
        if clock.monotonic() - self._sent >= _PAUSE:
            self._send_held()

    def _send_held(self) -> None:
        """Send the held batches as one, since each message has a large fixed cost."""
        held, self._held, self._sent = self._held, [], clock.monotonic()
        for _, alike in groupby(held, _names):
            together = list(alike)
            signals = [
                {name: np.concatenate([batch[side][name] for batch in together]) for name in together[0][side]}
                for side in (1, 2, 3)
            ]
            self._send(np.concatenate([batch[0] for batch in together]), *signals)

    def _send(
        self,
        index: np.ndarray,
        bench: Mapping[str, np.ndarray],
        twin: Mapping[str, np.ndarray],
        residuals: Mapping[str, np.ndarray],
    ) -> None:
        for name in SHOWN:
            at = f"{ROOT}/{name}"
            if name in bench:
                send(self._stream, f"{at}/curves/bench", index, bench[name])
            if name in twin:
                send(self._stream, f"{at}/curves/twin", index, twin[name])
            if name in residuals:
                send(self._stream, f"{at}/residual/twin", index, np.asarray(residuals[name]) * _MILLI)
                send_noise(self._stream, f"{at}/residual", index, self._noise[name] * _MILLI)
                if self._noise[name] > 0.0:
                    send(self._stream, f"error/{name}", index, self._levels(name, index, residuals[name]))
        if "unexplained_torque" in residuals:
            send(self._stream, "unexplained_torque", index, np.asarray(residuals["unexplained_torque"]) * _MILLI)
        if self._gearing is not None:
            self._turn(self._gearing, index, bench, twin)

    def _levels(self, name: str, index: np.ndarray, residual: np.ndarray) -> np.ndarray:
        """RMSE over the last second, relative to the sensor's noise floor [dB] (n,)."""
        power = self._windows[name].mean_squares(index, residual) / self._noise[name] ** 2
        return 10.0 * np.log10(np.maximum(power, 10.0 ** (0.1 * _LEAST_LEVEL)))

    def _turn(
        self, gearing: Gearing, index: np.ndarray, bench: Mapping[str, np.ndarray], twin: Mapping[str, np.ndarray]
    ) -> None:
        """Turn the gear train by the measured angle of the motor (else the twin's), some pictures a second."""
        angle, current = (_known(name, bench, twin) for name in ("motor_position", "current"))
        if angle is None or current is None:
            return
        number = np.floor(index / _PICTURE)
        rows = np.flatnonzero((np.diff(number, prepend=self._pictured) != 0.0) & np.isfinite(angle))
        self._pictured = number[-1]
        if len(rows):
            torque = np.nan_to_num(np.asarray(current)[rows]) * self._torque_constant
            motion = by_ratios(gearing, index[rows], np.asarray(angle)[rows], torque)
            send_motion(self._stream, gearing, motion, _full_colours(gearing))

    def tell(self, time: float, text: str) -> None:
        """Add a line to the log of events at a time [s]."""
        self._stream.set_time(TIMELINE, duration=time)
        self._stream.log("story", rr.TextLog(text))
        self._stream.reset_time()

    def close(self) -> None:
        """Send what is still buffered, and close.

        Raises InputError if the file cannot be written, RuntimeError if the viewer did not take everything.
        """
        self._send_held()
        if isinstance(self.into, Path):
            finish_file(self._stream, self.into)
        else:
            finish_viewer(self._stream)


def _known(name: str, *sides: Mapping[str, np.ndarray]) -> np.ndarray | None:
    """The signal from the first side that has it: live sides hold every signal, NaN if it is not measured."""
    return next((side[name] for side in sides if name in side and np.isfinite(side[name]).any()), None)


def _names(batch: _Batch) -> list[list[str]]:
    return [list(signals) for signals in batch[1:]]


def _full_colours(gearing: Gearing) -> np.ndarray:
    return by_ratios(gearing, np.zeros(1), np.zeros(1), np.full(1, _FULL)).strongest


def live_blueprint(gearing: Gearing | None = None) -> rrb.Blueprint:
    """The tabs of a live view: all signals side by side, then each alone for a narrow screen."""

    def column(name: str, tab: str | None = None) -> rrb.Container:
        legend = tab is not None or name == SHOWN[0]
        return signal_column(path_of(ROOT, name), name, UNITS[name], f"m{UNITS[name]}", tab=tab, legend=legend)

    told = [
        rrb.TimeSeriesView(
            origin="/error",
            name="RMSE of the last second relative to the noise [dB]",
            plot_legend=rrb.PlotLegend(rrb.Corner2D.LeftBottom),  # errors fall, so this corner is free
        ),
        rrb.TimeSeriesView(
            origin="/unexplained_torque",
            name="unexplained torque [mN m, motor shaft]",
            plot_legend=rrb.PlotLegend(visible=False),
        ),
        rrb.TextLogView(
            origin="/story",
            name="events",
            columns=rrb.TextLogColumns(timeline_columns=[TIMELINE], text_log_columns=["Body"]),
        ),
    ]
    compare = rrb.Vertical(
        rrb.Horizontal(*map(column, SHOWN)), rrb.Horizontal(*told), row_shares=[3, 1], name="compare"
    )
    tabs = [compare, *(column(name, signal_words(name)) for name in SHOWN)]
    if gearing is not None:
        tabs.append(train_tab("as measured", _full_colours(gearing), gearing, simulated=False))
    return layout(tabs)

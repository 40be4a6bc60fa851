"""Rerun views of a live run: in a window, in a browser, or in a file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..model import Model
from ..nodes.live_session import Pair
from ..views.screen import open_live_viewer, why_not_shown
from .output import console, warn

if TYPE_CHECKING:
    from ..views.rerun_view import RerunView
    from ..views.web_viewer import WebViewer

_BETWEEN = 100_000_000
"""Gap in ns between two runs on the view's time axis."""


class LiveView:
    """The rerun views of a live run; takes batches of pairs. A viewer that fails is dropped with a warning."""

    def __init__(self, *views: RerunView) -> None:
        self._views = list(views)
        self._zero: int | None = None  # ns, of the stamps: when the view's time began
        self._last = 0

    def take(self, pairs: Sequence[Pair]) -> None:
        """Show a batch of pairs from the running monitor."""
        time = [self._time(pair.stamp) for pair in pairs]

        def columns(side: str) -> dict[str, np.ndarray]:
            names = getattr(pairs[0], side).keys()
            return {name: np.array([getattr(pair, side)[name] for pair in pairs], float) for name in names}

        batch = time, columns("bench"), columns("twin"), columns("residuals")
        for view in tuple(self._views):
            self._try(view, lambda view: view.add(*batch))

    def _time(self, stamp: int) -> float:
        """Seconds since the first sample; a run that is played again follows the one before."""
        if self._zero is None:
            self._zero = stamp
        elif stamp <= self._last:
            self._zero -= self._last - stamp + _BETWEEN
        self._last = stamp
        return (stamp - self._zero) * 1e-9

    def tell(self, time: float, text: str) -> None:
        """Add a line to the log of events at this time [s]."""
        for view in tuple(self._views):
            self._try(view, lambda view: view.tell(time, text))

    def tell_now(self, text: str) -> None:
        """Add a line to the log of events at the sample that was shown last."""
        self.tell(0.0 if self._zero is None else (self._last - self._zero) * 1e-9, text)

    def close(self) -> None:
        """Write what is still buffered and close the views. Raises InputError if a file cannot be written."""
        with ExitStack() as held:
            for view in self._views[::-1]:
                held.callback(self._try, view, lambda view: view.close())

    def _try(self, view: RerunView, action: Callable[[RerunView], None]) -> None:
        try:
            action(view)
        except Exception:
            if not isinstance(view.into, str):
                raise
            if view in self._views:
                self._views.remove(view)
                warn("the viewer closed before it had shown all samples; the run goes on without it")


def open_view(
    rrd: Path | None, headless: bool, web: WebViewer | None, floors: dict[str, float], model: Model
) -> LiveView | None:
    """Open the requested rerun views: a file, a browser, or a viewer if there is a screen; None if there is none."""
    into: list[Path | str] = [rrd] if rrd is not None else []
    if web is not None:
        into.append(web.sink)
    if not headless and web is None:
        if reason := why_not_shown():
            instead = "give --web or --rrd FILE" if rrd is None else f"{rrd} is written instead"
            console.print(f"The viewer is not opened because {reason}: {instead}.", style="dim", markup=False)
        elif sink := open_live_viewer():
            into.append(sink)
        else:
            warn("the viewer did not start; the run goes on without it: give --web or --rrd FILE")
    if not into:
        return None
    from ..views.rerun_view import RerunView

    shown = web.sink if web is not None else None
    return LiveView(*(RerunView(each, "ema-twin live", floors, model=model, in_browser=each == shown) for each in into))

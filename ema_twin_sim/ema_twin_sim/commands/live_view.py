"""Rerun beside a live run: in a window, in a browser, or into a file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from .output import console

if TYPE_CHECKING:
    from ..model import Model
    from ..nodes.live import Pair
    from ..views.web_viewer import WebViewer

_BETWEEN = 100_000_000
"""ns in the view between two runs."""


class LiveView:
    """The rerun view of a live run; takes batches of pairs."""

    def __init__(self, view) -> None:
        self._view = view
        self._zero: int | None = None  # ns, of the stamps: when the view's time began
        self._last = 0

    def take(self, pairs: Sequence[Pair]) -> None:
        """A batch of pairs from the running monitor."""
        import numpy as np

        time = [self._time(pair.stamp) for pair in pairs]

        def columns(side: str) -> dict[str, np.ndarray]:
            names = getattr(pairs[0], side).keys()
            return {name: np.array([getattr(pair, side)[name] for pair in pairs], float) for name in names}

        self._view.add(time, columns("bench"), columns("twin"), columns("residuals"))

    def _time(self, stamp: int) -> float:
        """Seconds since the first sample; what is played again follows what was played before."""
        if self._zero is None:
            self._zero = stamp
        elif stamp <= self._last:
            self._zero -= self._last - stamp + _BETWEEN
        self._last = stamp
        return (stamp - self._zero) * 1e-9

    def tell(self, time: float, text: str) -> None:
        """A line of the story."""
        self._view.tell(time, text)

    def tell_now(self, text: str) -> None:
        """A line of the story at the sample that was shown last."""
        self._view.tell(0.0 if self._zero is None else (self._last - self._zero) * 1e-9, text)

    def close(self) -> None:
        """Write what is held back."""
        self._view.close()


def open_view(
    rrd: Path | None, headless: bool, web: WebViewer | None, floors: dict[str, float], model: Model
) -> LiveView | None:
    """The rerun view that is wanted: a file, a browser, a viewer where there is a screen and one may, or none."""
    from ..views.screen import open_live_viewer, why_not_shown

    sinks = [web.sink] if web is not None else []
    if not headless and web is None:
        if reason := why_not_shown():
            instead = "give --web or --rrd FILE" if rrd is None else f"{rrd} is written instead"
            console.print(f"The viewer stays closed, {reason}: {instead}.", style="dim", markup=False)
        else:
            sinks.append(open_live_viewer())
    if rrd is None and not sinks:
        return None
    from ..views.rerun_view import RerunView

    return LiveView(RerunView(rrd, "ema-twin live", floors, sinks=sinks, model=model))

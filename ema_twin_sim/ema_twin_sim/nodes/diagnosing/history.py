"""The last samples that were compared, in a bounded memory, and recordings of them. No ROS."""

from __future__ import annotations

import threading

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.nodes.sample_codec import FIELDS, State
from ema_bench_replay.recording import SIGNALS, Recording

_FIRST_ROOM = 4096
_SHORTEST = 2.0  # s of a run before the present one that are worth looking at
ENOUGH = 15.0
"""s that are looked back over where no window is asked for, if the present run has lasted less."""

_MEASURED = tuple(name for name in SIGNALS if name != "unexplained_torque")


class History:
    """The last samples of the bench, run by run; one thread adds while another asks.

    Memory grows with what is held, up to 170 bytes a sample, and then stays.
    """

    def __init__(self, capacity: int) -> None:
        """Hold up to `capacity` samples."""
        self._capacity = capacity
        self._rows = np.empty((min(capacity, _FIRST_ROOM), len(FIELDS)))
        self._stamps = np.empty(len(self._rows), np.int64)
        self._passes = np.empty(len(self._rows), np.int64)
        self._count = 0  # samples ever taken
        self._changing = threading.Lock()

    def add(self, number: int, sample: State) -> None:
        """Take a sample; `number` rises where the bench begins anew (a run, or a step back in time)."""
        with self._changing:
            if self._count == len(self._rows) < self._capacity:
                self._grow()
            place = self._count % len(self._rows)
            self._rows[place] = list(sample.signals.values())
            self._stamps[place], self._passes[place] = sample.stamp, number
            self._count += 1

    def recordings(self, window: float, name: str) -> list[Recording]:
        """The last `window` s of all runs, the oldest first.

        Without a window (0), the present run from its beginning, and as many before it, whole, as make ENOUGH: nobody
        knows in which state a cut begins.

        Signals that a run lacks are absent. Raises InputError where nothing was compared yet.
        """
        stamps, passes, rows = self._held()
        if not len(stamps):
            raise InputError("no sample was compared yet; start the bench (or replay) and the twin")
        left, found = window or ENOUGH, []
        runs = np.unique(passes)
        for number in runs[::-1]:
            first, last = np.searchsorted(passes, [number, number + 1])
            if window:
                first += np.searchsorted(stamps[first:last], stamps[last - 1] - round(left * 1e9))
            lasts = float(stamps[last - 1] - stamps[first]) * 1e-9
            left -= lasts
            if lasts >= _SHORTEST or number == runs[-1]:
                found.append(_recording(stamps[first:last], rows[first:last], f"{name}, run {number - runs[0] + 1}"))
            if left <= 0.0:
                break
        if len(found[0]) < 2:
            raise InputError("one sample was compared so far; wait for more")
        return found[::-1]

    def _held(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Copies of stamps (n,), numbers of the runs (n,) and rows (n, fields), the oldest first."""
        with self._changing:
            held = min(self._count, len(self._rows))
            order = (np.arange(held) + (self._count - held)) % len(self._rows)
            return self._stamps[order], self._passes[order], self._rows[order]

    def _grow(self) -> None:
        """Twice the room; the ring has not come round yet."""
        more = min(2 * len(self._rows), self._capacity)
        for name in ("_rows", "_stamps", "_passes"):
            before = getattr(self, name)
            after = np.empty((more, *before.shape[1:]), before.dtype)
            after[: len(before)] = before
            setattr(self, name, after)


def _recording(stamps: np.ndarray, rows: np.ndarray, name: str) -> Recording:
    columns = dict(zip(FIELDS, rows.T, strict=True))
    return Recording(
        name=name,
        stamps=stamps - stamps[0],
        signals={signal: columns[signal] for signal in _MEASURED if np.isfinite(columns[signal]).any()},
        start=int(stamps[0]),
        motor_angle_origin=float(columns["motor_angle_origin"][0]),
        output_angle_origin=float(columns["output_angle_origin"][0]),
    ).from_zero()

"""The last compared samples, in bounded memory, and recordings made of them."""

from __future__ import annotations

import threading

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.nodes.sample_codec import FIELDS
from ema_bench_replay.recording import SIGNALS, Recording
from ema_bench_replay.sample import State

_FIRST_ROOM = 4096
_SHORTEST = 2.0  # s; a shorter run is used only if there is no longer one
ENOUGH = 15.0
"""Time in s to look back if no window is given and the present run is shorter."""

_MEASURED = tuple(name for name in SIGNALS if name != "unexplained_torque")


class History:
    """The last samples of the bench, run by run; one thread adds while another reads.

    Memory grows with the samples held, up to 170 bytes per sample of the capacity, and then stays.
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
        """Take a sample; `number` increases when the bench restarts (a new run, or a step back in time)."""
        with self._changing:
            if self._count == len(self._rows) < self._capacity:
                self._grow()
            place = self._count % len(self._rows)
            self._rows[place] = list(sample.signals.values())
            self._stamps[place], self._passes[place] = sample.stamp, number
            self._count += 1

    def recordings(self, window: float, name: str) -> list[Recording]:
        """The last `window` s over all runs, the oldest first.

        Without a window (0): the present run from its beginning, and as many whole runs before it as give ENOUGH.
        Runs are kept whole because the state at a cut is unknown.

        Signals that a run lacks are absent. Raises InputError if nothing was compared yet.
        """
        with self._changing:
            held = min(self._count, len(self._rows))
            order = (np.arange(held) + (self._count - held)) % len(self._rows)
            stamps, passes = self._stamps[order], self._passes[order]
            runs = np.unique(passes)
            parts = [(slice(*span), number) for number, span in _spans(stamps, passes, runs, window)]
            # the stream waits for this lock: copy only what is needed
            rows = [self._rows[order[part]] for part, _ in parts]
        if not parts or stamps[parts[-1][0]].size < 2:
            raise InputError("no sample was compared yet; start the bench (or replay) and the twin")
        return [
            _recording(stamps[part], held_rows, f"{name}, run {number - runs[0] + 1}")
            for (part, number), held_rows in zip(parts, rows, strict=True)
        ]

    def _grow(self) -> None:
        """Double the memory; the ring has not wrapped round yet."""
        more = min(2 * len(self._rows), self._capacity)
        for name in ("_rows", "_stamps", "_passes"):
            before = getattr(self, name)
            after = np.empty((more, *before.shape[1:]), before.dtype)
            after[: len(before)] = before
            setattr(self, name, after)


def _spans(
    stamps: np.ndarray, passes: np.ndarray, runs: np.ndarray, window: float
) -> list[tuple[int, tuple[int, int]]]:
    """The runs to use, the oldest first, and the range of samples of each; the last short one if all are short."""
    left = window or ENOUGH
    found: list[tuple[int, tuple[int, int]]] = []
    short: list[tuple[int, tuple[int, int]]] = []
    for number in runs[::-1].tolist():
        first, last = np.searchsorted(passes, [number, number + 1]).tolist()
        if window:
            first += int(np.searchsorted(stamps[first:last], stamps[last - 1] - round(left * 1e9)))
        lasts = float(stamps[last - 1] - stamps[first]) * 1e-9
        left -= lasts
        (found if lasts >= _SHORTEST else short).append((number, (first, last)))
        if left <= 0.0:
            break
    return found[::-1] or short[:1]


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

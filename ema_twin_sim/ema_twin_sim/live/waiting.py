"""Samples of one side that wait for their partner from the other, by their number in a run. No ROS."""

from __future__ import annotations

import struct
from operator import itemgetter

from ema_bench_replay.sample import VALUES, State

CAPACITY = 25_000
"""Number of samples of a side that may wait: more than can be in transit. Fast DDS keeps 5000 samples per reader at the
writer and 500 at the reader (see loopback.xml), both on the way to the twin and on the way back; beyond that a
publisher waits. Where somebody's own profile is used, it keeps 5000 at the reader."""

_ROW = struct.Struct(f"<QQq{len(VALUES)}d")
"""A row: number of the clearing after which it was kept (0: the row is free); sequence; stamp; values."""
_HEAD = struct.Struct("<QQ")
_FREE = bytes(_HEAD.size)
_values = itemgetter(*VALUES)


class Waiting:
    """Waiting samples of one run: a ring of rows with a fixed place for each number.

    A sample replaces the one of an earlier number in its place. Memory is allocated once; kept as objects, samples
    would take ten times as much.
    """

    def __init__(self, capacity: int) -> None:
        """Keep up to `capacity` samples with consecutive numbers."""
        self._rows = bytearray(capacity * _ROW.size)
        self._capacity = capacity
        self._since = 1  # number of clearings, counted from 1
        self._count = 0
        self._run = 0

    def __len__(self) -> int:
        return self._count

    def keep(self, sample: State) -> None:
        """Keep a sample until it is taken."""
        place = sample.sequence % self._capacity * _ROW.size
        since, _ = _HEAD.unpack_from(self._rows, place)
        self._count += since != self._since
        self._run = sample.run
        _ROW.pack_into(self._rows, place, self._since, sample.sequence, sample.stamp, *_values(sample.signals))

    def take(self, sequence: int) -> State | None:
        """Remove and return the sample of this number; None if it is not waiting."""
        place = sequence % self._capacity * _ROW.size
        if _HEAD.unpack_from(self._rows, place) != (self._since, sequence):
            return None
        _, _, stamp, *values = _ROW.unpack_from(self._rows, place)
        self._free(place)
        return State(self._run, sequence, stamp, dict(zip(VALUES, values, strict=True)))

    def forget_before(self, sequence: int) -> None:
        """Drop the samples with a smaller number."""
        for place in range(0, len(self._rows), _ROW.size):
            since, number = _HEAD.unpack_from(self._rows, place)
            if since == self._since and number < sequence:
                self._free(place)

    def clear(self) -> None:
        """Drop all samples."""
        self._since += 1
        self._count = 0

    def _free(self, place: int) -> None:
        self._rows[place : place + _HEAD.size] = _FREE
        self._count -= 1

"""States that wait for their partner, in memory allocated once; as objects, each would take ten times as much."""

from __future__ import annotations

import struct

from ema_bench_replay.nodes.sample_codec import FIELDS, State

_ROW = struct.Struct(f"<QQq{len(FIELDS)}d")
"""A row: number of the clearing after which it was kept (0: the row is free); sequence; stamp; signals."""
_HEAD = struct.Struct("<QQ")
_FREE = _HEAD.pack(0, 0)


class WaitingStates:
    """A `live.waiting.Waiting` of states: a ring of rows with a fixed place for each number.

    A state replaces the one of an earlier number in its place.
    """

    def __init__(self, capacity: int) -> None:
        """Keep up to `capacity` states with consecutive numbers."""
        self._rows = bytearray(capacity * _ROW.size)
        self._capacity = capacity
        self._since = 1  # number of clearings, counted from 1
        self._count = 0
        self._run = 0

    def __len__(self) -> int:
        return self._count

    def keep(self, sample: State) -> None:
        """See `Waiting`."""
        place = sample.sequence % self._capacity * _ROW.size
        since, _ = _HEAD.unpack_from(self._rows, place)
        self._count += since != self._since
        self._run = sample.run
        _ROW.pack_into(self._rows, place, self._since, sample.sequence, sample.stamp, *sample.signals.values())

    def take(self, sequence: int) -> State | None:
        """See `Waiting`."""
        place = sequence % self._capacity * _ROW.size
        if _HEAD.unpack_from(self._rows, place) != (self._since, sequence):
            return None
        _, _, stamp, *values = _ROW.unpack_from(self._rows, place)
        self._free(place)
        return State(self._run, sequence, stamp, dict(zip(FIELDS, values, strict=True)))

    def forget_before(self, sequence: int) -> None:
        """See `Waiting`."""
        for place in range(0, len(self._rows), _ROW.size):
            since, number = _HEAD.unpack_from(self._rows, place)
            if since == self._since and number < sequence:
                self._free(place)

    def clear(self) -> None:
        """See `Waiting`."""
        self._since += 1
        self._count = 0

    def _free(self, place: int) -> None:
        self._rows[place : place + _HEAD.size] = _FREE
        self._count -= 1

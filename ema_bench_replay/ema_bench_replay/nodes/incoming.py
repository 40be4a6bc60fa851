"""States received on a topic from any sender: no message may end the receiving node."""

from __future__ import annotations

import math
import struct

from ema_bench_replay.sample import State

from .sample_codec import read_state

BEYOND_ALL = 1e12
"""No machine's signal is larger in SI units. A flipped bit can make it so large that its square overflows."""
_UNREADABLE = (struct.error, IndexError, ValueError, OverflowError, RuntimeError)  # RuntimeError: raised by rclpy


class Incoming:
    """Reads the messages of one topic, and counts faulty ones.

    Attributes:
        unreadable: messages that are not an EmaState, and were skipped.
        absurd: values that are infinite or impossibly large; they are treated as unknown.
    """

    def __init__(self, topic: str) -> None:
        """`topic` is named in the messages."""
        self._topic = topic
        self.unreadable = 0
        self.absurd = 0

    def read(self, message: bytes) -> State | None:
        """The state in a message; None if it holds none."""
        try:
            state = read_state(message)
        except _UNREADABLE:
            self.unreadable += 1
            return None
        wrong = [name for name, value in state.signals.items() if abs(value) > BEYOND_ALL]  # NaN does not count
        if wrong:
            self.absurd += len(wrong)
            state.signals.update(dict.fromkeys(wrong, math.nan))
        return state

    @property
    def complaint(self) -> str:
        """What was wrong, in words; empty if nothing was."""
        told = []
        if self.unreadable:
            told.append(f"{self.unreadable} messages on {self._topic} are no EmaState and were left out")
        if self.absurd:
            told.append(f"{self.absurd} values on {self._topic} are infinite or absurd and count as unknown")
        return "; ".join(told)

    @property
    def figures(self) -> dict[str, object]:
        """The counts by name, for the diagnostics."""
        return {
            f"messages on {self._topic} that are no EmaState": self.unreadable,
            f"values on {self._topic} that are infinite or absurd": self.absurd,
        }

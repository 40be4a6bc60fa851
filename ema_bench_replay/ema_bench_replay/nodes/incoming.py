"""States as they arrive on a topic, from whoever sends them: nothing that comes may end the node that listens."""

from __future__ import annotations

import math
import struct

from .sample_codec import State, read_state

BEYOND_ALL = 1e12
"""In SI units no machine's signal is larger; what a wrong bit makes of one is, and its square beyond all numbers."""
_UNREADABLE = (struct.error, IndexError, ValueError, OverflowError, RuntimeError)  # RuntimeError: rclpy's own


class Incoming:
    """Reads the messages of one topic, and counts what was wrong with them.

    Attributes:
        unreadable: messages that are no EmaState, and were left out.
        absurd: values that are infinite or beyond all machines; they are taken for unknown.
    """

    def __init__(self, topic: str) -> None:
        """`topic` is named in what is said of it."""
        self._topic = topic
        self.unreadable = 0
        self.absurd = 0

    def read(self, message: bytes) -> State | None:
        """The state that a message holds; None where it holds none."""
        try:
            state = read_state(message)
        except _UNREADABLE:
            self.unreadable += 1
            return None
        wrong = [name for name, value in state.signals.items() if abs(value) > BEYOND_ALL]  # NaN is not
        if wrong:
            self.absurd += len(wrong)
            state.signals.update(dict.fromkeys(wrong, math.nan))
        return state

    @property
    def complaint(self) -> str:
        """What was wrong, in words; empty where nothing was."""
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

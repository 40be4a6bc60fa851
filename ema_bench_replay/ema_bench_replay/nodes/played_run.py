"""One run of a replay, from a sample of the recording to its end. No ROS."""

from __future__ import annotations

from ema_bench_replay.recording import Recording


class PlayedRun:
    """The samples of one run; sequence and positions count from its first sample.

    Attributes:
        number: the run's number.
        part: the part of the recording that is played.
    """

    def __init__(self, recording: Recording, first: int, number: int) -> None:
        """Begin the run at the sample with index `first`."""
        self.number = number
        self.part = recording.between(float(recording.time[first]))
        self._first = first
        self._columns = list(self.part.signals.items())
        self._origins = self.part.origins

    def sample(self, index: int) -> tuple[int, int, dict[str, float]]:
        """Stamp [ns since the epoch], sequence and fields (SI) of the recording's sample at `index`."""
        sequence = index - self._first
        values = {name: column.item(sequence) for name, column in self._columns}
        return self.part.start + self.part.stamps.item(sequence), sequence, values | self._origins

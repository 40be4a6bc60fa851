"""Schedule of a recording's samples. No ROS: the caller supplies the clock."""

from __future__ import annotations

import numpy as np

from ema_bench_replay.errors import InputError


class Playback:
    """The schedule of a recording's samples against a monotonic clock, `now` [ns].

    A sample's deadline is the start of the pass plus its time in the recording divided by `rate`. Deadlines are
    absolute, so a late caller catches up and nothing drifts. A *pass* is an uninterrupted sequence of samples: each
    start, loop and seek begins one; a pause does not.

    Attributes:
        rate: playing speed, 1 is real time; 0 plays as fast as possible.
        first: index of the first sample of this pass.
        next: index of the next sample; the number of samples once all were played.
        passes: number of passes begun, including this one.
        paused: whether time stands still.
    """

    def __init__(
        self,
        stamps: np.ndarray,
        *,
        rate: float = 1.0,
        loop: bool = False,
        start: float = 0.0,
        paused: bool = False,
        now: int = 0,
    ) -> None:
        """Plan to play from `start` [s].

        Args:
            stamps: int64 (n,), ns since the recording's first sample, increasing from 0.
            rate: see the class.
            loop: begin again at `start` after the last sample.
            start: time of the first sample to play, also in later loops; s since the recording's first sample.
            paused: begin paused.
            now: the clock [ns].

        Raises:
            InputError: if `start` is not within the recording.
        """
        self._stamps = stamps
        self._start = self.index_at(start)
        self.rate = rate
        self._loop = loop
        self.paused = paused
        self.passes = 0
        self._steps = 0
        self._begin(self._start, now)

    def index_at(self, position: float) -> int:
        """Index of the first sample at or after `position` [s]. Raises InputError if there is none."""
        duration = int(self._stamps[-1]) * 1e-9
        if not 0.0 <= position <= duration:
            raise InputError(f"position: {position:g} s is not within the recording; give 0 to {duration:g} s")
        return int(np.searchsorted(self._stamps, min(round(position * 1e9), self._stamps[-1])))

    @property
    def ended(self) -> bool:
        """Whether the last sample was played (a loop never ends)."""
        return self.next == len(self._stamps)

    def wait(self, now: int) -> int | None:
        """Time [ns] until sample `next` is due, 0 or negative if it is due; None while paused, and at the end."""
        if self.ended or (self.paused and not self._steps):
            return None
        return self._deadline() - now if self.rate and not self.paused else 0

    def played(self) -> None:
        """Advance after sample `next` was played. In a loop, a new pass follows the last sample."""
        self.next += 1
        if self._steps:
            self._steps -= 1
        if self.ended and self._loop:
            self._begin(self._start, self._deadline())

    def position(self, now: int) -> int:
        """Present position, also between samples: ns since the recording's first sample."""
        last = int(self._stamps[max(self.next - 1, self.first)])
        if self.paused or not self.rate or self.ended:
            return last
        reached = self._anchor_stamp + int((now - self._anchor) * self.rate)
        return min(max(reached, last), int(self._stamps[self.next]))

    def start(self, now: int) -> None:
        """Start the clock: sample `next` is due now."""
        self._anchor = now
        self._anchor_stamp = self._stamp_of_next()

    def pause(self) -> None:
        """Stop time."""
        self.paused = True

    def resume(self, now: int) -> None:
        """Continue a paused playback at once with the next sample."""
        if self.paused:
            self.paused = False
            self._steps = 0
            self.start(now)

    def step(self) -> None:
        """Make one more sample due while paused. Raises InputError if not paused, or at the end."""
        if not self.paused:
            raise InputError("step: playing is not paused; pause it first")
        if self.ended:
            raise InputError("step: the recording has ended; seek back first")
        self._steps += 1

    def seek(self, position: float, now: int) -> None:
        """Begin a new pass at the first sample from `position` [s] on. Raises InputError outside the recording."""
        self._begin(self.index_at(position), now)

    def set_rate(self, rate: float, now: int) -> None:
        """Change the rate from the next sample on."""
        self.rate = rate
        self.start(now)

    def _begin(self, index: int, now: int) -> None:
        self.first = self.next = index
        self.passes += 1
        self._steps = 0
        self.start(now)

    def _deadline(self) -> int:
        if not self.rate:
            return self._anchor
        return self._anchor + int((self._stamp_of_next() - self._anchor_stamp) / self.rate)

    def _stamp_of_next(self) -> int:
        """The stamp of sample `next`; after the last sample, one sample period later."""
        if not self.ended:
            return int(self._stamps[self.next])
        period = np.median(np.diff(self._stamps)) if len(self._stamps) > 1 else 1_000_000_000
        return int(self._stamps[-1]) + int(period)

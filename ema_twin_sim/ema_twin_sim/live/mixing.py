"""Whether the samples of two nodes mix on one topic. No ROS."""

from __future__ import annotations

from .sample_stream import SampleStream

FEW = 5
"""Samples out of order that a single restart may cause: a node that was killed stays listed for some seconds."""


class Mixing:
    """Watches how many nodes publish a topic and what arrives on it: with two publishers every sample is disturbed."""

    def __init__(self, stream: SampleStream) -> None:
        """`stream` judges the samples that arrive."""
        self._stream = stream
        self._before = 0
        self._two = False

    def look(self, publishers: int) -> None:
        """Take the number of nodes that publish the topic now; called several times a second."""
        self._two = publishers > 1
        if not self._two:
            self._before = self._disturbed

    @property
    def mixed(self) -> bool:
        """Whether there are two publishers or more, and more than `FEW` samples came out of order since."""
        return self._two and self._disturbed - self._before > FEW

    @property
    def _disturbed(self) -> int:
        stream = self._stream
        return stream.runs + stream.backward + stream.duplicate + stream.late

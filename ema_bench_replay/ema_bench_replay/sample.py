"""One sample of a bench or its twin, as the nodes pass it on."""

from __future__ import annotations

from typing import NamedTuple

from ema_bench_replay.recording import ANGLE_ORIGINS, SIGNALS

VALUES = (*SIGNALS, *ANGLE_ORIGINS)
"""Names of all values of a sample."""


class State(NamedTuple):
    """One sample: `stamp` in ns since the epoch, all VALUES in SI units, NaN where unknown."""

    run: int
    sequence: int
    stamp: int
    signals: dict[str, float]

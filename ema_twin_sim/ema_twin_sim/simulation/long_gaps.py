"""Gaps in a recording that are too long for a twin to integrate across, and the part to use instead."""

from __future__ import annotations

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording

LONGEST_GAP = 60.0
"""Longest gap without samples, s, across which a twin integrates."""


def refuse_long_gaps(recording: Recording, second: float) -> None:
    """Raise InputError, with all that is to be cut, if gaps are too long; ``second`` is its unit of time in s."""
    gaps = [gap for gap in recording.gaps if second * gap.duration > LONGEST_GAP]
    if not gaps:
        return
    longest = max(gaps, key=lambda gap: gap.duration)
    begins = [0.0, *(gap.time + gap.duration for gap in gaps)]
    ends = [*(gap.time for gap in gaps), recording.duration]
    begin, end = max(zip(begins, ends, strict=True), key=lambda stretch: stretch[1] - stretch[0])
    options = [f"--from {_cut(second * begin)}"] if begin > 0.0 else []
    options += [f"--to {_cut(second * end)}"] if end < recording.duration else []
    of_all = f", the longest of {len(gaps)} gaps over {LONGEST_GAP:g} s" if len(gaps) > 1 else ""
    raise InputError(
        f"{recording.name}: {second * longest.duration:.4g} s are missing at {second * longest.time:.4g} s{of_all}; "
        f"cut it there: the longest stretch without such a gap, {second * (end - begin):.4g} s, is {' '.join(options)}"
    )


def _cut(time: float) -> str:
    """A time [s] to cut at, in hundredths: within the gap, or as good as at its edge."""
    return f"{time:.2f}".rstrip("0").rstrip(".")

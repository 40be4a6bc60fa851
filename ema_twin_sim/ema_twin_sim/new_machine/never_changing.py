"""Signals that never change, as those of a sensor that is not connected: they show no motion, or no drive."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ema_bench_replay.recording import Recording

_POSITIONS = ("motor_position", "output_position")
_AT_ZERO = ("speed", "current", "motor_torque")
"""May be steady, but not zero all along."""


def never_changes(values: np.ndarray | None) -> bool:
    """Whether all known values (n,) are the same; False if there are fewer than two."""
    known = np.zeros(0) if values is None else values[np.isfinite(values)]
    return len(known) > 1 and float(np.ptp(known)) == 0.0


def zero_all_along(values: np.ndarray | None) -> bool:
    """Whether all known values (n,) are zero; False if there are fewer than two."""
    return values is not None and never_changes(values) and not np.nan_to_num(values).any()


def never_changing(recordings: Sequence[Recording]) -> tuple[str, ...]:
    """The positions that are the same in all samples of all recordings, and a speed or a drive that is always zero.

    A speed or a torque that is steady may be true, and operating points may be at rest. A motor's position beside a
    speed that changes is judged by that.
    """
    if any(recording.of_points for recording in recordings):
        return ()
    held = [name for name in (*_POSITIONS, *_AT_ZERO) if all(recording.has(name) for recording in recordings)]
    stands = {name: zero_all_along if name in _AT_ZERO else never_changes for name in held}
    still = [name for name in held if all(stands[name](recording.signals[name]) for recording in recordings)]
    if "speed" in held and "speed" not in still:
        still = [name for name in still if name != "motor_position"]
    return tuple(still)

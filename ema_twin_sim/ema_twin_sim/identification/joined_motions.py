"""Motions of several recordings, one after another in memory, so that one compiled call computes the torque of all.

A search computes thousands of predictions. A call for each recording would spend much of its time in the interpreter,
which only one thread can use at a time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ..measured.observation import Observation
from ..plant.layout import Effects
from .required_rows import require, require_of


@dataclass(frozen=True, eq=False)
class JoinedMotions:
    """Motions, kernels and torque rows of R recordings; recording k begins at sample ``starts[k]``."""

    motion: np.ndarray  # (n, 7) with the columns MOTION
    starts: np.ndarray  # int64 (R + 1,)
    kernels: np.ndarray
    kernel_starts: np.ndarray  # int64 (R + 1,)
    rows: np.ndarray  # int64 (s,), samples of their recording at which the torque is judged
    row_starts: np.ndarray  # int64 (R + 1,)
    halves: tuple[tuple[int, int], ...]  # (first, end) recordings, for two threads

    @classmethod
    def of(cls, observations: Sequence[Observation]) -> JoinedMotions:
        """Copy the arrays of the observations."""
        motion, starts = _joined([o.motion for o in observations])
        kernels, kernel_starts = _joined([o.kernel for o in observations])
        rows, row_starts = _joined([o.rows for o in observations])
        middle = int(np.argmin(np.abs(starts - 0.5 * starts[-1])))
        cuts = sorted({0, middle, len(observations)})
        return cls(motion, starts, kernels, kernel_starts, rows.astype(np.int64), row_starts, tuple(pairwise(cuts)))

    def part(self, k: int) -> slice:
        """Samples of recording ``k``."""
        return slice(int(self.starts[k]), int(self.starts[k + 1]))

    def require(
        self,
        recordings: tuple[int, int],
        plant: np.ndarray,
        effects: Effects,
        origins: np.ndarray,
        seen: np.ndarray,
        has_seen: np.ndarray,
        reuse_output_motion: bool,
        required: np.ndarray,
        torque: np.ndarray,
    ) -> None:
        """Fill ``required`` (n, 4) and the smoothed ``torque`` (s,) [N m] of the ``recordings`` (first, end).

        ``origins`` (R, 2) [rad] are the readings of motor and output counter at position zero. ``seen`` (n,) [rad, slow
        shaft] holds the measured output position of the recordings with ``has_seen`` (R,); see ``inverse_dynamics``.
        """
        first, end = recordings
        where = (self.motion, self.starts, origins, self.kernels, self.kernel_starts, self.rows, self.row_starts)
        require(first, end, plant, effects, *where, seen, has_seen, reuse_output_motion, required, torque)

    def require_of(
        self,
        plant: np.ndarray,
        address: int,
        place: int,
        slots: np.ndarray,
        origins: np.ndarray,
        required: np.ndarray,
        torque: np.ndarray,
    ) -> float:
        """Fill the smoothed ``torque`` (s,) [N m] that one effect alone needs; see ``inverse_dynamics_of``."""
        where = (self.motion, self.starts, origins, self.kernels, self.kernel_starts, self.rows, self.row_starts)
        least: float = require_of(plant, address, place, slots, *where, required, torque)
        return least


def _joined(arrays: Sequence[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Arrays one after another, and where each starts and the last ends."""
    return np.concatenate(arrays), np.cumsum([0, *map(len, arrays)], dtype=np.int64)

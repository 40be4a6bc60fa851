"""One feature of a run, or the mean of several runs, beside its healthy value."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..criteria import SIGNIFICANT


@dataclass(frozen=True)
class Change:
    """A feature of a run and its healthy value."""

    name: str
    value: float
    unit: str
    healthy: float  # in the same unit
    standard_deviations: float  # of one more healthy run of one more test
    size: float = np.inf  # the healthy value in these standard deviations; infinite for logarithms, which have no zero

    @property
    def growth(self) -> float:
        """By which share it grew; NaN if the healthy value is not known to differ from zero."""
        return self.value / self.healthy - 1.0 if abs(self.size) > SIGNIFICANT and self.healthy else np.nan


def mean_changes(runs: Sequence[Mapping[str, Change]]) -> dict[str, Change]:
    """Mean of each feature over those runs that have it."""
    found = {}
    for name in sorted({name for run in runs for name in run}):
        its = [run[name] for run in runs if name in run]
        found[name] = replace(
            its[0],
            value=float(np.mean([one.value for one in its])),
            healthy=float(np.mean([one.healthy for one in its])),
            standard_deviations=float(np.mean([one.standard_deviations for one in its])),
            size=float(np.mean([one.size for one in its])),
        )
    return found


def growths(changes: Mapping[str, Change]) -> dict[str, float]:
    """By which share each feature grew, where that is known."""
    return {name: one.growth for name, one in changes.items() if np.isfinite(one.growth)}

"""Acquisition: is a run fit to be judged, and by which of its signals? Checked before anything is said of the unit."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..criteria import NEGLIGIBLE, PART, SMALL
from .motion_record import MotionRecord
from .phases import phases_of
from .sign_of_effort import Sign, sign_of


@dataclass(frozen=True)
class Extent:
    """How much a run holds; zero if that is unknown."""

    duration: float = 0.0  # s
    strokes: int = 0  # both ways


@dataclass(frozen=True)
class Acquisition:
    """What is wrong with a run's signals, and what can be judged nevertheless."""

    usable: bool  # whether anything can be said of the unit
    effort_usable: bool  # whether the size of its effort can be judged
    unsigned: bool  # whether the effort is a magnitude
    findings: tuple[str, ...]
    extent: Extent = Extent()
    certain_of_sign: bool = True  # whether it could not be read the other way

    @property
    def fit_to_learn_from(self) -> bool:
        """Whether a healthy run can be used to learn the healthy state."""
        return self.usable and self.effort_usable

    def read_as(self, unsigned: bool) -> Acquisition:
        """The same, with an effort that is not certain to be a magnitude, or none, read as one or not."""
        if self.certain_of_sign or unsigned == self.unsigned:
            return self
        old, new = (Sign(flag, certain=False).words for flag in (self.unsigned, unsigned))
        findings = tuple(new if finding == old else finding for finding in self.findings)
        return replace(self, unsigned=unsigned, findings=findings)


def judge_acquisition(record: MotionRecord) -> Acquisition:
    """Check the clock, samples that are no numbers, clipping, and the sign of the effort."""
    wrong = clock_fault(record.time)
    for name in ("position", "effort", "command", "motor_position"):
        values = getattr(record, name)
        missing = 0.0 if values is None else float(np.mean(~np.isfinite(values)))
        if missing:
            wrong = wrong or f"{missing:.1%} of the samples of the {name.replace('_', ' ')} are no numbers"
    if wrong:
        return Acquisition(False, False, bool(record.unsigned), (f"The {wrong}; record again.",))
    phases = phases_of(record)
    if not (phases.strokes(1) or phases.strokes(-1)):
        return Acquisition(False, False, bool(record.unsigned), ("The machine makes no stroke; record motion.",))
    findings = []
    sign = sign_of(record, phases)
    if sign.words:
        findings.append(sign.words)
    clipped = clipped_share(record.effort)
    if clipped > NEGLIGIBLE:
        findings.append(
            f"The effort is clipped in {clipped:.0%} of the samples; it is not judged. Widen the sensor's range."
        )
    usable = clipped <= NEGLIGIBLE and np.ptp(record.effort) > 0.0
    if not np.ptp(record.effort) > 0.0:
        findings.append("The effort never changes and is not judged. Check its sensor.")
    extent = Extent(float(record.time[-1] - record.time[0]), len(phases.strokes(1)) + len(phases.strokes(-1)))
    return Acquisition(True, bool(usable), sign.unsigned, tuple(findings), extent, sign.certain)


def clock_fault(time: np.ndarray) -> str:
    """What is wrong with a clock (n,) [s]: stamps that do not rise, uneven steps, or gaps; empty if it is fine.

    Single lost samples do not affect means and spectra over positions; many do.
    """
    steps = np.diff(time)
    if not len(steps) or not np.isfinite(time).all() or (steps <= 0.0).any():
        return "clock does not rise from sample to sample"
    period = float(np.median(steps))
    uneven = float(np.mean(np.abs(steps - period) > PART * period))
    if uneven > SMALL:
        return f"clock is uneven: {uneven:.0%} of its steps are off their median of {period:.3g} s by over a quarter"
    lost = float(steps[steps > (1.0 + PART) * period].sum()) / float(time[-1] - time[0])
    if lost > SMALL:
        return f"clock has gaps of {lost:.0%} of the run"
    return ""


def clipped_share(values: np.ndarray) -> float:
    """Share of the samples (n,) that are clipped: at an end of the range, and over three times those just inside it.

    In a signal that is only coarsely resolved, the last reading is no more frequent than the one before it.
    """
    found, counts = np.unique(values, return_counts=True)
    if len(found) < 4:
        return 0.0
    ends = ((counts[-1], counts[-2]), (counts[0], counts[1]))
    return float(sum(end for end, inside in ends if end > 3 * inside)) / len(values)

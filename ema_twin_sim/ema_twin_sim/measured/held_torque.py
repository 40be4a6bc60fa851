"""A current or torque that a log repeats for several samples, since it is read less often than it is logged.

It is late by half of the time between two readings. A regression on fast motion then takes inertia for friction; more
samples do not help, a log of each reading does.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ema_bench_replay.recording import Recording

from ..criteria import LIKELY, MOSTLY, NEARLY_ALL
from .way_by_speed import FEWEST


def telling_repeats(recording: Recording) -> Recording:
    """The recording, with a warning if its current or torque is new in only some of its samples."""
    name = recording.drive
    every = None if name is None or recording.of_points else samples_repeated(recording, name)
    if name is None or every is None:
        return recording
    late = 0.5e3 * (every - 1.0) * recording.sample_period
    told = (
        f"the {name.replace('_', ' ')} is new only once in {every:.2g} samples, so that it is {late:.2g} ms late on "
        "average and inertia and fast effects come out wrong; log it as often as it is read"
    )
    return replace(recording, warnings=(*recording.warnings, f"{recording.name}: {told}"))


def samples_repeated(recording: Recording, name: str) -> float | None:
    """For how many samples a signal shows each of its readings, two or more; None if its readings have no such rate.

    A coarse reading of what changes slowly is repeated too, but not as regularly, or it changes by single counts.
    """
    lengths, steps = [], []
    for part in recording.spread():
        values = part.signals[name][np.isfinite(part.signals[name])]
        change = np.diff(values)
        places = np.flatnonzero(change)
        lengths.append(np.diff(places))
        steps.append(np.abs(change[places]))
    samples, step = np.concatenate(lengths), np.concatenate(steps)
    if len(samples) < FEWEST or not (usual := float(np.median(samples))) >= LIKELY:
        return None
    times = np.rint(samples / usual)  # more than once where readings were the same
    if np.mean(times >= 1) < NEARLY_ALL or np.mean(times <= 1) < MOSTLY or np.median(step) < LIKELY * step.min():
        return None
    return float(np.mean(samples[times == 1]))

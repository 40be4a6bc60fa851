"""Fit of a machine with backlash or compliance to the simulated closed loop of its recordings.

The equation error uses a motion sampled every few milliseconds, while teeth meet in less time. Its contact is therefore
softer than the real one, which shifts the shares of both sides by a few per cent. In the closed loop this shifts every
impact by milliseconds and causes most of the current error. The simulated loop uses the model's own contact. So a few
Levenberg-Marquardt steps on the loop error start where the equation error ends, over the first seconds of the
recordings whose impacts are predictable. All recordings then decide whether the new numbers follow better.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording

from ..criteria import BESIDE_IMPACTS, CHAOTIC, CORRELATION, FAR_OFF_ROW, NEGLIGIBLE
from ..effects import catalogue
from ..identification.equation import EquationErrorProblem
from ..identification.fit import fit, prior_rows
from ..identification.hypothesis import Hypothesis
from ..parallel import simulations
from ..plant.motion import ACCELERATION
from ..reading_noise import reading_noise
from ..simulation.sensor_noise import counter_noise
from ..simulation.simulate_many import simulate_many
from .search.trace import Search
from .split import ClosedLoop

JUDGED = ("current", "output_position", "motor_position")
SECONDS = 6.0  # own s of a recording that are simulated
STEPS = 4  # most steps under each weighting
ENOUGH = 5e-3  # relative decrease of the cost below which the iteration stops
TRIED = ((0.0, 1.0), (1e-2, 1.0), (0.0, 0.4), (1e-1, 0.5))  # (damping, fraction of the step), tried in turn
FINER = 0.2  # times the usual finite-difference step: an impact lasts a fraction of a millisecond
UNCOUNTED = 1e12  # counts per turn: counter steps would hide the effect of a small change


def with_followed_numbers(loop: ClosedLoop, found: Search) -> Search:
    """The search, with numbers that make the closed loop follow the recordings, if these follow better."""
    best, problem = found.fit, found.problem
    if not best.parted or not found.taken or {*loop.inputs} != {"setpoint"}:
        return found
    calm = [
        recording
        for recording, o in zip(loop.recordings, problem.observations, strict=True)
        if float(np.abs(o.motion[:, ACCELERATION]).max()) < CHAOTIC and all(map(recording.has, JUDGED))
    ]
    if not calm:
        return found
    followed = _Following(problem, calm, best.hypothesis).fitted()
    before, after = loop.errors((best.hypothesis, followed))
    return found.with_numbers(fit(problem, followed, 0)) if after < (1.0 - NEGLIGIBLE) * before else found


class _Following:
    """Minimises the closed-loop error, in units of noise, over the beginnings of some recordings."""

    def __init__(self, problem: EquationErrorProblem, recordings: Sequence[Recording], start: Hypothesis) -> None:
        model = start.model()
        one = {side: counter_noise(model, side) for side in ("motor", "output")}
        # if the model gives no noise, estimate it from the recordings
        current = model.value("sensors.current_noise") or max(reading_noise(r.signals["current"]) for r in recordings)
        self._start = start
        self._recordings = [_beginning(recording) for recording in recordings]
        self._ratio = model.value("machine.gear_ratio")
        self._noise = current, math.hypot(one["output"], one["motor"] / self._ratio)
        self._lower, self._upper = problem.bounds(start)
        settled = [name for name, one in start.added.items() if catalogue()[one.effect].settle is not None]
        kinds = ("scale.", "contact.", *(f"effects.{name}." for name in settled))
        # an added torque shows in every motion, so the equation error already determines it well
        self._moving = [
            k for k, free in enumerate(start.free) if free.path.startswith(kinds) and free.lower < free.upper
        ]

    def fitted(self) -> Hypothesis:
        """The hypothesis with the best-following numbers. Outliers have little weight in the second pass."""
        h = self._start
        told = self._moving and min(self._noise) > 0.0  # without noise, every row is an outlier
        for cauchy_scale in (FAR_OFF_ROW, BESIDE_IMPACTS) if told else ():
            try:
                h = self._descended(h, cauchy_scale)
            except InputError:  # some nearby numbers cannot be simulated
                break
        return h

    def _descended(self, h: Hypothesis, cauchy_scale: float) -> Hypothesis:
        (rows,) = self._missed([h])
        inflation = CORRELATION * max(1.0, (1.4826 * float(np.median(np.abs(rows)))) ** 2)

        def cost(rows: np.ndarray, h: Hypothesis) -> float:
            pr, _ = prior_rows(h, inflation)
            return float((cauchy_scale**2 * np.log1p((rows / cauchy_scale) ** 2)).sum() + pr @ pr)

        least = cost(rows, h)
        for _ in range(STEPS):
            for trial in self._trials(h, rows, cauchy_scale, inflation):
                (missed,) = self._missed([trial])
                fall = least - cost(missed, trial)
                if fall > 0.0:
                    break
            else:
                break
            h, rows, least = trial, missed, least - fall
            if fall < ENOUGH * least:
                break
        return h

    def _trials(self, h: Hypothesis, rows: np.ndarray, cauchy_scale: float, inflation: float) -> list[Hypothesis]:
        """Hypotheses after steps of several lengths, from one with residual ``rows`` (m,)."""
        moving = np.array(self._moving)
        upper, lower, values = self._upper[moving], self._lower[moving], h.values[moving]
        change = np.array([FINER * h.free[k].step for k in moving])
        change = np.where(values + change <= upper, change, -change)
        there = self._missed([h.at(h.values + one) for one in change[:, None] * np.eye(len(h.values))[moving]])
        slopes = np.stack([(rows - missed) / by for missed, by in zip(there, change, strict=True)], 1)
        counts = 1.0 / (1.0 + (rows / cauchy_scale) ** 2)
        pr, pj = prior_rows(h, inflation)
        pj = pj[:, moving]
        curvature = slopes.T @ (counts[:, None] * slopes) + pj.T @ pj
        downhill = slopes.T @ (counts * rows) + pj.T @ pr
        free = np.flatnonzero(~(((values <= lower) & (downhill < 0.0)) | ((values >= upper) & (downhill > 0.0))))
        size = np.sqrt(np.maximum(np.diag(curvature)[free], 1e-30))
        normal = curvature[np.ix_(free, free)] / np.outer(size, size)
        trials = []
        for damping, share in TRIED:
            step = np.zeros(len(h.values))
            solved = np.linalg.solve(normal + (damping + 1e-9) * np.eye(len(free)), downhill[free] / size) / size
            step[moving[free]] = share * solved
            trials.append(h.at(np.clip(h.values + step, self._lower, self._upper)))
        return trials

    def _missed(self, hypotheses: Sequence[Hypothesis]) -> list[np.ndarray]:
        """Residual rows (m,) of each hypothesis's loop, in units of noise: current, then encoder difference."""
        models = [h.model() for h in hypotheses]
        for side in ("motor", "output"):
            models = [model.with_value(f"sensors.{side}_encoder_counts", UNCOUNTED) for model in models]

        def beside(recording: Recording) -> list[np.ndarray]:
            return [self._between(recording, twin) for twin in simulate_many(models, recording, "setpoint")]

        parts = simulations(beside, self._recordings)
        return [np.concatenate(rows) for rows in zip(*parts, strict=True)]

    def _between(self, recording: Recording, twin: Recording) -> np.ndarray:
        current, output, motor = (
            recording.signals[name][1:] - twin.signals[name][1:]  # both start from the first sample
            for name in JUDGED
        )
        difference = output - motor / self._ratio
        rows = (current / self._noise[0], (difference - np.nanmedian(difference)) / self._noise[1])
        return np.nan_to_num(np.concatenate(rows))


def _beginning(recording: Recording) -> Recording:
    """The first seconds of a recording: a loop is started where the recording began."""
    end = int(np.searchsorted(recording.time, recording.time[0] + SECONDS))
    signals = {name: values[:end] for name, values in recording.signals.items()}
    return replace(recording, stamps=recording.stamps[:end], signals=signals)

"""Misfit of the method ``simulation``: the closed loop compared with each recording, over all signals but the input.

Each signal counts in units of its sensor's noise, or of the residual that no parameter values remove, if that is
larger. Positions integrate, so the offset left by the first sample's noise is removed; for the motor position, so is
the effect of a setpoint recorded slightly off or late. Rows do not count while the machine stands still and until its
speed loop has forgotten it, because dry friction at rest depends on unmeasured states; a model with a bristle describes
them. After impacts, twin and machine need not agree sample by sample, so rows count less there.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from ema_bench_replay.recording import Recording

from ..criteria import OUTLIER, SMALL, STANDSTILL
from ..measured.observation import Observation
from ..measured.sliding import moving_maximum
from ..model import Model
from ..model.roles import BRISTLE
from ..parallel import simulations
from ..plant.motion import SPEED, TIME
from ..simulation.compared_signals import ENCODER_DIFFERENCE, noise_floors
from ..simulation.longest_step import coarse_step
from ..simulation.sensor_noise import counter_noise
from ..simulation.simulate_many import simulate_many
from .free_parameters import FreeParameters
from .misfit import Last

LINGER = 0.06  # own s around standstill in which rows do not count
LEAP = 5.0  # finite-difference steps over which jumps are looked for
LEAPS = 3  # number of times that they are looked for
MOST_ROWS = 600_000  # rows beyond which samples are skipped
FINE = 1e12  # counts per turn: counter steps would hide the effect of a small change
UNMEASURED = 1e-4  # of a signal's size: its noise if the model gives zero


@dataclass(frozen=True, eq=False)
class _Part:
    """One signal of one recording: samples (n,), measured (n,), its noise, weights (n,), drifts to remove (n, k)."""

    recording: int
    signal: str
    samples: np.ndarray
    measured: np.ndarray
    noise: float
    trust: np.ndarray
    drift: np.ndarray


class SimulationMisfit:
    """The closed-loop error over all recordings, in units of noise.

    ``observations`` are of the same recordings; ``sources`` are the inputs of the twins.
    """

    def __init__(
        self,
        recordings: Sequence[Recording],
        observations: Sequence[Observation],
        freedom: FreeParameters,
        sources: Sequence[str],
    ) -> None:
        self.variance = 1.0
        self.freedom = freedom
        self._recordings = tuple(recordings)
        self._sources = tuple(sources)
        every = max(1, math.ceil(4 * sum(len(recording) for recording in recordings) / MOST_ROWS))
        self._parts = [
            part
            for k, given in enumerate(zip(recordings, observations, sources, strict=True))
            for part in _parts(k, *given, freedom.model, every)
        ]
        edges = np.cumsum([0, *(len(part.samples) for part in self._parts)])
        self._slices = [slice(int(a), int(b)) for a, b in pairwise(edges)]
        self.parts: list[tuple[int, slice]] = [
            (part.recording, rows) for part, rows in zip(self._parts, self._slices, strict=True)
        ]
        self.rows = int(edges[-1])
        self._spread = np.ones(len(self._parts))
        self._trust = np.concatenate([part.trust for part in self._parts])
        self._predict = Last(lambda values: self._predict_all([values], None)[0])
        self._changes = Last(self._differences)
        self._coarse = coarse_step(freedom.model)
        self._runs([freedom.start], 0, None)  # compiles an effect here, rather than in several threads at once

    def check(self, values: np.ndarray) -> None:
        """Raise InputError if no twin can be simulated with these values at the coarsest step used."""
        self._runs([values], 0, self._coarse)

    def doubt(self, values: np.ndarray) -> None:
        """Down-weight rows that jump with a small change of the parameters.

        An impact or a break-away then happens sooner or later. Such rows cannot be linearised, neither in a step of the
        fit nor in a standard error.
        """
        numbers = self.freedom.numbers
        lower, upper = np.array([n.lower for n in numbers]), np.array([n.upper for n in numbers])
        size = np.array([n.step * n.slope(v) for n, v in zip(numbers, values, strict=True)]) * LEAP
        random = np.random.default_rng(0)  # all parameters at once, each up or down: few runs find all jumps
        moved = []
        for _ in range(LEAPS):
            step = size * random.choice([-1.0, 1.0], len(size))
            step[(values - np.abs(step) < lower) | (values + np.abs(step) > upper)] = 0.0
            moved += [values + step, values - step]
        here, *there = self._predict_all([values, *moved], self._coarse)
        noise = np.concatenate([np.full(len(part.samples), part.noise) for part in self._parts])
        leaps = np.zeros(self.rows)
        for up, down in zip(there[::2], there[1::2], strict=True):
            leaps += ((up + down - 2.0 * here) / noise) ** 2
        self._trust = np.concatenate([part.trust for part in self._parts]) / np.sqrt(1.0 + leaps)

    def residual(self, values: np.ndarray) -> np.ndarray:
        """Measured minus predicted (m,) at these values (k,)."""
        predicted = self._predict(values)
        rows = np.empty(self.rows)
        for part, here, spread in zip(self._parts, self._slices, self._spread, strict=True):
            left = (part.measured - predicted[here]) / (part.noise * spread)
            if part.drift.shape[1]:
                left -= np.median(left)
                for _ in range(2):
                    left = _without(left, part.drift, part.trust / np.sqrt(1.0 + (left / OUTLIER) ** 2))
            rows[here] = left
        return rows

    def slopes(self, values: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """Weighted slopes of the prediction (m, k) with respect to each parameter."""
        return np.stack([self._settled(change, weights) for change in self._changes(values)], 1)

    def _settled(self, change: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """A change of the prediction (m,), in units of noise and weighted, minus the drifts removed from a residual."""
        rows = np.empty(self.rows)
        for part, here, spread in zip(self._parts, self._slices, self._spread, strict=True):
            rows[here] = _without(change[here] / (part.noise * spread), part.drift, weights[here]) * weights[here]
        return rows

    def _differences(self, values: np.ndarray) -> list[np.ndarray]:
        """Change of the prediction (m,) per unit of each parameter, by central differences.

        With one-sided differences, the kinks of friction and backlash would bias every step, and no fit would converge.
        """
        numbers = self.freedom.numbers
        lower, upper = np.array([n.lower for n in numbers]), np.array([n.upper for n in numbers])
        steps = np.array([n.step * n.slope(v) for n, v in zip(numbers, values, strict=True)])
        down, up = np.minimum(steps, values - lower), np.minimum(steps, upper - values)
        points = [*(values + np.diag(up)), *(values - np.diag(down))]
        there = self._predict_all(points, self._coarse)
        return [
            (above - below) / width
            for above, below, width in zip(there[: len(steps)], there[len(steps) :], up + down, strict=True)
        ]

    def _predict_all(self, points: Sequence[np.ndarray], step: float | None, shift: float = 0.0) -> list[np.ndarray]:
        runs = simulations(lambda k: self._runs(points, k, step, shift), range(len(self._recordings)))
        return [np.concatenate(of_point) for of_point in zip(*runs, strict=True)]

    def zero_shift(self, values: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """Weighted change of the prediction (m,) if every motor counter's zero is off by its noise."""
        there = self._predict_all([values], None, counter_noise(self.freedom.model, "motor"))[0]
        return self._settled(there - self._predict(values), weights)

    def systematic(self, values: np.ndarray) -> np.ndarray:
        """Zero: a simulation has no systematic error relative to its model."""
        return np.zeros(len(values))

    def weights(self, residual: np.ndarray) -> np.ndarray:
        """Square roots (m,) of the row weights, which decrease for outliers."""
        return self._trust / np.sqrt(1.0 + (residual / OUTLIER) ** 2)

    def cost(self, residual: np.ndarray) -> float:
        """Cauchy misfit."""
        return float(OUTLIER**2 * (self._trust**2 @ np.log1p((residual / OUTLIER) ** 2)))

    def reweigh(self, residual: np.ndarray) -> bool:
        """Weight each part by how well it can be matched at all; return whether that changed much."""
        before, self._spread = self._spread, self._spread.copy()
        for k, (part, here) in enumerate(zip(self._parts, self._slices, strict=True)):
            trusted = part.trust > 0.5
            if trusted.any():
                bulk = 1.4826 * float(np.median(np.abs(residual[here][trusted])))
                self._spread[k] = max(1.0, before[k] * bulk)
        return bool((np.abs(np.log(self._spread / before)) > SMALL).any())

    def _runs(self, points: Sequence[np.ndarray], k: int, step: float | None, shift: float = 0.0) -> list[np.ndarray]:
        """The twins' signals for one recording, its parts one after the other; ``shift`` [rad] of the motor zero."""
        models = [self.freedom.at(values) for values in points]
        for side in ("motor", "output"):
            models = [model.with_value(f"sensors.{side}_encoder_counts", FINE) for model in models]
        recording = self._recordings[k]
        recording = replace(recording, motor_angle_origin=recording.motor_angle_origin + shift)
        twins = simulate_many(models, recording, self._sources[k], step=step)
        return [self._seen(twin, model, k) for twin, model in zip(twins, models, strict=True)]

    def _seen(self, twin: Recording, model: Model, k: int) -> np.ndarray:
        signals = dict(twin.signals)
        ratio = model.value("machine.gear_ratio")
        signals[ENCODER_DIFFERENCE] = signals["output_position"] - signals["motor_position"] / ratio
        return np.concatenate([signals[part.signal][part.samples] for part in self._parts if part.recording == k])


def _parts(
    k: int, recording: Recording, observation: Observation, source: str, model: Model, every: int
) -> list[_Part]:
    """Parts of one recording that are judged: the motion if the current is the input, else also the current."""
    seen = dict(recording.signals)
    floors = noise_floors(model, has_speed=recording.has("speed"), period=recording.sample_period)
    ratio = model.value("machine.gear_ratio")
    noise = {"current": floors["current"], "speed": floors["speed"], "motor_position": counter_noise(model, "motor")}
    if recording.has("output_position"):
        seen[ENCODER_DIFFERENCE] = seen["output_position"] - seen["motor_position"] / ratio
        noise[ENCODER_DIFFERENCE] = floors[ENCODER_DIFFERENCE]
    if source == "current":
        del noise["current"]
        if recording.has("speed"):
            del noise["motor_position"]  # it adds nothing, and drifts
    motion, below_shock_limit, settled = _observed(recording, observation, model)
    flat = np.ones(len(recording))
    found = []
    for signal, floor in noise.items():
        if signal not in seen:
            continue
        measured = seen[signal]
        good = np.isfinite(measured)
        good[0] = False  # both start from the first sample
        good &= np.arange(len(recording)) % every == 0
        samples = np.flatnonzero(good)
        if not len(samples):
            continue
        drifts = {"motor_position": [flat, recording.time, motion], ENCODER_DIFFERENCE: [flat]}.get(signal, [])
        trust = below_shock_limit * settled if signal == ENCODER_DIFFERENCE else below_shock_limit
        size = float(np.sqrt(np.mean(measured[samples] ** 2)))
        found.append(
            _Part(
                k,
                signal,
                samples,
                measured[samples],
                max(floor, UNMEASURED * size, 1e-12),
                trust[samples],
                np.array(drifts).reshape(len(drifts), -1).T[samples] if drifts else np.empty((len(samples), 0)),
            )
        )
    return found


def _observed(
    recording: Recording, observation: Observation, model: Model
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(speed (n,), row weights (n,), whether the output has settled since the last impact (n,))."""
    motion, period = observation.motion, observation.period
    counts = 1.0 / observation.shaken
    bristled = any(e.enabled and e.effect == BRISTLE for e in model.effects.values())
    if not bristled:
        still = np.abs(motion[:, SPEED]) < STANDSTILL
        linger = round(LINGER / period)
        counts[moving_maximum(still, linger, linger)] = 0.0
    settled = (~observation.after_impact).astype(float)
    # an observation has an even grid; a recording may not
    speed, counts, settled = (
        np.interp(recording.time, motion[:, TIME], values) for values in (motion[:, SPEED], counts, settled)
    )
    return speed, counts, settled


def _without(rows: np.ndarray, drift: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Rows (n,) minus the drifts (n, k) that they contain, by weighted least squares."""
    if not drift.shape[1]:
        return rows
    weighted = drift * (weights**2)[:, None]
    normal = weighted.T @ drift
    size = np.sqrt(np.maximum(np.diag(normal), 1e-300))
    normal = normal / np.outer(size, size) + 1e-9 * np.eye(len(size))  # at constant speed, drifts are alike
    return rows - drift @ (np.linalg.solve(normal, (rows @ weighted) / size) / size)

"""The judgement on unseen data: each recording simulated with numbers that were fitted to the others."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording

from ..comparison.running_comparison import share_removed
from ..criteria import CLEARLY_MORE
from ..identification.equation import EquationErrorProblem
from ..identification.fit import Fit
from ..identification.parallel import simulations
from ..identification.uncertainty import held_out
from ..model import Model
from ..model.own_units import in_si, shown
from ..simulation.sensor_noise import noise_floors
from ..simulation.simulate import BY_MOTOR, choose_input, simulate
from .search.trace import Search


@dataclass(frozen=True)
class Unseen:
    """RMSE of the headline signal after each round, the start included: pooled, and per recording.

    The last is the end's, with whatever constants it was refitted with.

    ``output`` is that of the output's position [rad], pooled; empty where it was not measured. Where the current drives
    the twin, whose positions then drift, it is what the ``encoders`` part by, beyond what the model lets them.
    """

    signal: str
    unit: str
    noise_floor: float
    rmse: tuple[float, ...]
    recordings: tuple[tuple[str, tuple[float, ...]], ...]
    output: tuple[float, ...]
    encoders: bool = False

    @property
    def betters(self) -> bool:
        """Whether the end is nearer to the recordings than the start: in the signal, in how the encoders part, or
        clearly in where the output is, and no farther in the signal.
        """
        if self.rmse[-1] < self.rmse[0]:
            return True
        if self.encoders:
            return self.output[-1] < self.output[0]
        return bool(self.output) and self.output[-1] < (1.0 / CLEARLY_MORE) * self.output[0] and not self.worsens

    @property
    def worsens(self) -> bool:
        """Whether the end is clearly farther from the recordings than the start."""
        return self.rmse[-1] > CLEARLY_MORE * max(self.rmse[0], self.noise_floor)

    def removed(self, before: int, after: int) -> float | None:
        """Share of the excess above the noise floor that went away between two rounds; None without excess."""
        return share_removed(self.rmse[before], self.rmse[after], self.noise_floor)

    def output_removed(self, before: int, after: int) -> float:
        """Share, in power, of the output's error that went away between two rounds; 0 where it is not judged.

        Where a measured current drives the twin, that is how far the encoders part.
        """
        if not self.output or not self.output[before]:
            return 0.0
        return 1.0 - (self.output[after] / self.output[before]) ** 2

    def shown(self, model: Model) -> Unseen:
        """The same in the units of the model's machine."""
        per, unit = shown(model, 1.0, self.unit)
        way, _ = shown(model, 1.0, "rad")
        return replace(
            self,
            unit=unit,
            noise_floor=per * self.noise_floor,
            rmse=tuple(per * value for value in self.rmse),
            recordings=tuple((name, tuple(per * value for value in values)) for name, values in self.recordings),
            output=tuple(way * value for value in self.output),
        )

    def as_json(self) -> dict[str, object]:
        """For ``--json``."""
        return {
            "signal": self.signal,
            "unit": self.unit,
            "noise_floor": self.noise_floor,
            "rmse": list(self.rmse),
            "encoder_difference" if self.encoders else "output_position": list(self.output),
            "recordings": [{"name": name, "rmse": list(values)} for name, values in self.recordings],
        }


def squares(model: Model, recording: Recording, source: str, signals: Sequence[str]) -> np.ndarray:
    """(sum of squares, samples) of what a simulated loop misses of each signal, one after the other (2 s,).

    NaN where such numbers make no motion that can be followed.
    """
    try:
        twin = simulate(model, recording, source)
    except InputError:
        return np.full(2 * len(signals), np.nan)
    found = []
    for name in signals:
        measured = 0.0 if name == "unexplained_torque" else recording.signals.get(name, np.nan)
        residual = np.asarray(measured - twin.signals[name])
        residual = residual[np.isfinite(residual)]
        found += [float(residual @ residual), len(residual)]
    return np.array(found)


def judge_unseen(
    problem: EquationErrorProblem, recordings: Sequence[Recording], found: Search, *, as_given: bool = False
) -> Unseen:
    """Simulate every recording (SI) after every round with the numbers that the other recordings gave.

    The end is the model ``as_given`` where nothing of it was changed.
    """
    base = found.fit.hypothesis.base
    inputs = [choose_input(recording, base) for recording in recordings]
    driven = any(source == "current" for source in inputs)  # one headline for all
    if driven:
        inputs = ["current"] * len(recordings)
    signal, unit = ("unexplained_torque", "N m") if driven else ("current", "A")
    if {*inputs} == {BY_MOTOR}:
        signal, unit = "output_position", "rad"
    fits: list[Fit] = [found.rounds[0].before, *(turn.after for turn in found.taken)]
    if len(fits) == 1 or fits[-1] is not found.fit:
        fits.append(found.fit)
    jobs: list[tuple[int, Recording, str, Model]] = []
    of_output: list[float] = []
    for k, f in enumerate(fits):
        # what is open in the model is no effect's merit: it begins with what fits best
        untouched = (k == 0 and not base.is_open) or (as_given and f is found.fit)
        fitted_to_all = untouched or len(recordings) < 2
        numbers = [f.hypothesis.values] * len(recordings) if fitted_to_all else held_out(problem, f)
        if driven and problem.rows > problem.size:
            of_output.append(_parting(problem, f, numbers))
        for recording, source, values in zip(recordings, inputs, numbers, strict=True):
            model = base if untouched else f.hypothesis.at(values).model()
            jobs.append((k, recording, source, in_si(model)))

    signals = (signal, "output_position")
    table = np.array(list(simulations(lambda job: squares(job[3], job[1], job[2], signals), jobs)))
    table = table.reshape(len(fits), len(recordings), 4)
    rows, counts = table[:, :, 0], table[:, :, 1]
    floors = [noise_floors(in_si(base), has_speed=r.has("speed"), period=r.sample_period)[signal] for r in recordings]
    each = np.sqrt(rows / np.maximum(counts, 1))
    output = table[:, :, 2:].sum(axis=1)
    if signal == "current" and output[:, 1].all():
        of_output = [math.sqrt(s / n) for s, n in output]
    return Unseen(
        signal,
        unit,
        math.sqrt(sum(floor**2 for floor in floors) / len(floors)),
        tuple(math.sqrt(s / max(n, 1)) for s, n in zip(rows.sum(axis=1), counts.sum(axis=1), strict=True)),
        tuple((r.name, tuple(float(v) for v in each[:, k])) for k, r in enumerate(recordings)),
        tuple(of_output),
        driven and bool(of_output),
    )


def _parting(problem: EquationErrorProblem, f: Fit, numbers: Sequence[np.ndarray]) -> float:
    """RMS [rad, slow shaft] that the encoders part by, each recording's beside numbers that others gave."""
    square = 0.0
    for part, values in zip(problem.encoder_parts, numbers, strict=True):
        left = problem.residual(problem.predict(f.hypothesis.at(values)))[part] * problem.noise_of_encoders(part)
        square += float(left @ left)
    return math.sqrt(square / (problem.rows - problem.size))

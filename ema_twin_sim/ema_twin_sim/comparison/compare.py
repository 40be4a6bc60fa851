"""Compare models with recordings: RMSE per signal beside the sensors' noise floor, and where a model fails."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ema_bench_replay.recording import Recording

from ..model import Model
from ..simulation.simulate import choose_input, simulate
from ..simulation.twin import DEFAULT_STEP
from .running_comparison import UNITS, RunningComparison, SignalError
from .where import Dependence, Stretch, find_dependences

MIXED = "mixed"
"""The input of a comparison whose recordings are driven by different signals."""

Signals = dict[str, SignalError]


@dataclass(frozen=True)
class RecordingComparison:
    """One recording beside the twin: per signal ``{rmse, relative, noise_floor, unit, driven}`` in SI units."""

    name: str
    samples: int
    duration: float
    signals: Signals


@dataclass(frozen=True)
class Comparison:
    """A model beside recordings; ``overall`` pools all samples, ``where`` tells what the errors depend on."""

    model: str
    input: str
    recordings: tuple[RecordingComparison, ...]
    overall: Signals
    where: tuple[Dependence, ...]
    warnings: tuple[str, ...]

    def as_json(self) -> dict[str, object]:
        """For ``compare --json``."""
        return {
            "model": self.model,
            "input": self.input,
            "recordings": [vars(recording) for recording in self.recordings],
            "overall": self.overall,
            "where": [dependence.as_json() for dependence in self.where],
            "warnings": list(self.warnings),
        }


def compare(
    recordings: Sequence[Recording],
    model: Model,
    source: str | None = None,
    *,
    step: float = DEFAULT_STEP,
    progress: Callable[[str], None] = lambda name: None,
) -> Comparison:
    """Simulate the model beside each recording and compare; nothing is estimated.

    ``source`` is the input for all (``setpoint`` or ``current``; by default what each recording allows); ``progress``
    is called with each recording's name when it is done. Raises InputError where a recording lacks the input's signal.
    """
    inputs = [choose_input(recording, source) for recording in recordings]
    together = inputs[0] if len(set(inputs)) == 1 else MIXED
    pooled = RunningComparison(model, together)
    compared = []
    stretches: dict[str, list[Stretch]] = {name: [] for name in UNITS}
    for recording, chosen in zip(recordings, inputs, strict=True):
        twin = simulate(model, recording, chosen, step=step)
        running = RunningComparison(model, chosen, period=recording.sample_period)
        residuals = running.add_rows(recording.signals, twin.signals)
        for name in residuals.keys() & set(_explained(chosen)):
            stretches[name].append(_stretch(recording, twin, residuals[name]))
        compared.append(RecordingComparison(recording.name, len(recording), recording.duration, running.result()))
        pooled.include(running)
        progress(recording.name)
    torques = {"current": model.value("machine.torque_constant"), "unexplained_torque": 1.0}
    where = [
        dependence
        for name, parts in stretches.items()
        if parts
        for dependence in find_dependences(name, UNITS[name], parts, torques.get(name))
    ]
    return Comparison(
        model.name,
        together,
        tuple(compared),
        pooled.result(),
        tuple(where),
        tuple(warning for recording in recordings for warning in recording.warnings),
    )


def _explained(source: str) -> tuple[str, ...]:
    """The signals whose errors are traced to a place: the headline of the input, and the encoders' difference."""
    return ("unexplained_torque",) if source == "current" else ("current", "output_position")


def _stretch(recording: Recording, twin: Recording, residual: np.ndarray) -> Stretch:
    position = recording.signals.get("motor_position", twin.signals["motor_position"])
    speed = recording.signals.get("speed")
    if speed is None:
        speed = np.gradient(position, recording.time)
    origin = 0.0 if np.isnan(recording.motor_angle_origin) else recording.motor_angle_origin
    output = recording.signals.get("output_position", twin.signals["output_position"])
    return Stretch(residual, speed, position + origin, output, recording.time)

"""Curves of a recording and of a model simulated with it, sample by sample, in the units of the machine's file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ema_bench_replay.recording import Recording

from ..comparison.compare import TRACED_UNITS, explained_signals, in_native_units, stretch_of
from ..comparison.running_comparison import RunningComparison
from ..comparison.where import Stretch
from ..measured.scales import standstill, to_rotary_equivalent
from ..model import Model
from ..model.matching import BY_TORQUE
from ..model.own_units import shown
from ..simulation.compared_signals import driving
from ..simulation.encoder_difference import with_encoder_difference
from ..simulation.simulate import choose_input, simulate


@dataclass(frozen=True, eq=False)
class Curves:
    """One signal, float64 (n,) each: the measured values, and the residual (measured minus twin)."""

    measured: np.ndarray
    residual: np.ndarray
    unit: str


@dataclass(frozen=True, eq=False)
class Beside:
    """One recording with a model: the curves by signal, and the residuals to be shown against speed and position."""

    name: str
    way: str  # rad or m
    still: float  # rad/s or m/s of the motor; below it the direction means little
    time: np.ndarray  # s (n,)
    speed: np.ndarray  # (n,), of the motor
    motor_position: np.ndarray | None  # (n,)
    of_points: bool
    curves: Mapping[str, Curves]
    stretches: Mapping[str, Stretch]


def beside(
    recordings: Sequence[Recording], model: Model, source: str | None = None, *, step: float | None = None
) -> list[Beside]:
    """Simulate a model with each recording, as ``compare`` does; ``source`` is the input, ``step`` [s] as there.

    Raises InputError if a recording lacks the input's signal.
    """
    matched, model_of_drum = to_rotary_equivalent(recordings, model)
    inputs = [choose_input(recording, model_of_drum, source) for recording in matched]
    return [
        _beside(recording, model_of_drum, chosen, step, standstill(recordings, model, chosen))
        for recording, chosen in zip(matched, inputs, strict=True)
    ]


def _beside(recording: Recording, model: Model, source: str, step: float | None, slow: float) -> Beside:
    twin = simulate(model, recording, source, step=step)
    measured_signals, twin_signals = with_encoder_difference(model, recording, source, twin)
    residuals = RunningComparison(model, source, period=recording.sample_period).add_rows(
        measured_signals, twin_signals
    )
    ratio, constant = model.value("machine.gear_ratio"), model.value("machine.torque_constant")
    by_torque = BY_TORQUE in recording.metadata
    curves, stretches = {}, {}
    place = None
    for name, residual in residuals.items():
        driven = name in driving(source)
        measured = measured_signals["current" if name == "unexplained_torque" else name]
        if name == "unexplained_torque":
            measured = measured * constant
        elif name == "current" and by_torque:  # as compare names it
            name, measured, residual = "motor_torque", measured * constant, residual * constant
        place = in_native_units(model, name, stretch_of(recording, twin, residual, ratio))
        if driven:
            continue
        size, unit = shown(model, 1.0, TRACED_UNITS[name])
        curves[name] = Curves(measured * size, residual * size, unit)
        if name in (*explained_signals(source), "motor_torque"):
            stretches[name] = place
    speed = place.speed if place is not None else np.zeros(len(recording))
    motor = recording.signals.get("motor_position")
    way, unit_of_way = shown(model, 1.0, "rad")
    return Beside(
        recording.name,
        unit_of_way,
        slow * way,
        recording.time,
        speed,
        None if motor is None else motor * way,
        recording.of_points,
        curves,
        stretches,
    )

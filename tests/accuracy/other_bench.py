"""Another bench than the twin's own: it shares no code with the twin's plant and effects, and hides what it is told to.

``OtherBench(machine, hidden, unkind, seed).record(drive, seconds)`` gives the recording that its drive would trace.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ema_bench_replay.recording import Recording

from .commands import Drive
from .hide import HIDE
from .layout import BURST_COLUMNS, HARMONIC_COLUMNS, PLANT, STEP, STEP_NS, TRACE
from .machine import DRAWN, Machine, spring, stock_constants
from .plant import run
from .trace import Shown, shown_recording
from .unkind import Unkind

_ROWS = round(2_000_000 / STEP_NS)  # steps in the trace's period of 2 ms
_WARMING = 60.0  # s, time constant of a day's warming up
_LIGHT = 0.04  # of critical damping, where something rings


@dataclass(frozen=True)
class Cause:
    """Something hidden: a catalogue id (or one of ``hide.UNKNOWN``), its true values, and its options."""

    id: str
    values: Mapping[str, float]
    options: Mapping[str, str] = field(default_factory=dict)


@dataclass
class OtherBench:
    """A bench with hidden causes. Recordings are made one after another, as a day at the bench goes.

    ``motor_origin`` and ``output_origin`` [rad] are what the counters show where the shafts stand first; with
    ``moved`` each recording starts somewhere else, and the counters go with the shafts.
    """

    machine: Machine
    hidden: Sequence[Cause] = ()
    unkind: Unkind = field(default_factory=Unkind)
    seed: int | Sequence[int] = 0
    motor_origin: float = -math.pi
    output_origin: float = 1.276
    moved: bool = False
    held: float = 0.0

    def __post_init__(self) -> None:
        self.random = np.random.default_rng(self.seed)
        self._clock = 0.0  # s since the day began
        self._wander_phases = self.random.uniform(0.0, 2.0 * math.pi, 2)

    def record(self, drive: Drive, seconds: float = 20.0, name: str = "") -> Recording:
        """The recording of one command."""
        plants = np.zeros(1, PLANT)
        plant = plants[0]
        self._furnish(plant)
        self._place_counters(plant)
        harmonics: list[tuple[float, float, float, float]] = []
        bursts: list[tuple[float, float, float]] = []
        for cause in self.hidden:
            HIDE[cause.id](plant, harmonics, bursts, cause.values, cause.options, self.random, seconds)
        samples = self._samples(seconds)
        cycle = self.machine.cycle
        ticks = samples[-1] // cycle + 1
        size = self.unkind.controller_noise
        noise = self.random.normal(0.0, size, ticks) if size else np.zeros(ticks)
        trace = np.empty((len(samples), len(TRACE)))
        run(
            plants,
            np.array(harmonics, float).reshape(-1, HARMONIC_COLUMNS),
            np.array(bursts, float).reshape(-1, BURST_COLUMNS),
            drive(np.arange(ticks) * (cycle * STEP)),
            noise,
            cycle,
            samples,
            round(self.held / STEP),
            self.random.uniform(-1.0, 1.0) * plant["half_gap"],
            plant["wander"] == 0.0 and plant["warming"] == 0.0,
            trace,
        )
        self._clock += seconds + 10.0
        true = Shown(
            stamps=samples * STEP_NS,
            signals={signal: trace[:, k] for k, signal in enumerate(TRACE)},
            motor_origin=plant["motor_origin"],
            output_origin=plant["output_origin"],
        )
        return shown_recording(true, name or f"BancoEMA_{drive.name}", self.unkind, self.random)

    def _samples(self, seconds: float) -> np.ndarray:
        """Steps (m,) at which the trace is taken."""
        samples = np.arange(round(seconds * 1e9 / STEP_NS / _ROWS), dtype=np.int64) * _ROWS
        if self.unkind.uneven:
            off = self.random.uniform(-0.5, 0.5, len(samples) - 1) * self.unkind.uneven
            samples[1:] += np.rint(off * _ROWS).astype(np.int64)
        return samples

    def _place_counters(self, plant: np.void) -> None:
        travel = self.random.uniform(-0.6, 0.6) if self.moved else 0.0
        plant["output_origin"] = self.output_origin + travel
        plant["motor_origin"] = self.motor_origin + plant["ratio"] * travel
        if self.unkind.power_cycled:  # the counter shows something else where the shaft stands; phases are then its own
            plant["motor_origin"] += self.random.uniform(-math.pi, math.pi)

    def _furnish(self, plant: np.void) -> None:
        """The machine and its drive, with nothing hidden."""
        machine, unkind = self.machine, self.unkind
        parts = stock_constants()
        drive, winding = parts["drive"], parts["machine"]
        plant["ratio"] = machine.gear_ratio or winding["gear_ratio"]
        plant["believed_torque_constant"] = winding["torque_constant"]
        plant["back_emf"] = winding["back_emf_constant"]
        plant["resistance"] = winding["phase_resistance"]
        plant["inductance"] = winding["phase_inductance"]
        for name in ("torque_constant", *DRAWN):
            plant[name] = getattr(machine, name)
        plant["stiffness"], plant["damping"] = machine.gear
        # friction turns round over next to no travel, on both sides alike
        plant["bristle_stiffness"] = (machine.motor_level + machine.output_level) / machine.bristle_travel
        plant["bristle_damping"] = 0.05
        plant["elastic_share"] = machine.elastic_share
        plant["wander_period"] = plant["wander_period_2"] = plant["warming_time"] = 1.0
        for name in ("position_gain", "speed_limit", "speed_gain", "integral_time", "integral_limit", "torque_limit"):
            plant[name] = drive[name]
        plant["speed_gain"] *= machine.speed_gain
        plant["position_gain"] *= plant["ratio"] / winding["gear_ratio"]  # as much speed a turn of the motor
        plant["dead_band"] = drive["integral_dead_band"]
        plant["anti_windup"] = drive["anti_windup_time"]
        if unkind.gear_resonance:
            plant["stiffness"], plant["damping"] = spring(
                unkind.gear_resonance, _LIGHT, machine.motor_inertia, machine.output_inertia
            )
        if unkind.load_resonance:
            plant["load_share"] = 0.5
            load = 0.5 * machine.output_inertia
            plant["load_stiffness"], plant["load_damping"] = spring(
                unkind.load_resonance, _LIGHT, machine.motor_inertia + load, load
            )
        if unkind.wander:
            for k, (name, period) in enumerate((("", 170.0), ("_2", 61.0))):
                plant[f"wander_period{name}"] = period
                plant[f"wander_phase{name}"] = self._wander_phases[k] + 2.0 * math.pi * self._clock / period
            plant["wander"] = unkind.wander
        cooled = 1.0 - unkind.warming * (1.0 - math.exp(-self._clock / _WARMING))
        plant["motor_viscous"] *= cooled
        plant["output_viscous"] *= cooled
        plant["interpolation"] = unkind.interpolation
        plant["interpolation_lines"] = 4096.0

"""The measuring chain of the other bench: counters, noise, rounding, and what goes wrong in a trace."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ema_bench_replay.recording import Recording

from .machine import stock_constants
from .unkind import Unkind

_RPM = math.pi / 30.0
_VOLTAGE_NOISE = 0.05  # V
_JUMP = 2**20  # counts, as on the Politecnico's own trace


@dataclass(frozen=True)
class Shown:
    """What is true at the trace's instants: stamps [ns], signals (n,) each, what the counters show at angle zero."""

    stamps: np.ndarray
    signals: Mapping[str, np.ndarray]
    motor_origin: float
    output_origin: float


def shown_recording(true: Shown, name: str, unkind: Unkind, random: np.random.Generator) -> Recording:
    """The recording that the drive's trace would give."""
    sensors = stock_constants()["sensors"]
    count = len(true.stamps)
    signals = dict(true.signals)
    origins = {}
    for shaft, origin in (("motor", true.motor_origin), ("output", true.output_origin)):
        counts = sensors[f"{shaft}_encoder_counts"] / (2.0 * math.pi)
        noise = random.normal(0.0, sensors[f"{shaft}_encoder_noise"], count)
        read = np.rint((origin + signals[f"{shaft}_position"]) * counts + noise)
        read += np.rint(_spikes(count, unkind.spikes, random) * 300.0)
        signals[f"{shaft}_position"] = (read - read[0]) / counts
        origins[f"{shaft}_angle_origin"] = float(read[0] / counts)
    signals["current"] = signals["current"] + random.normal(0.0, sensors["current_noise"], count)
    signals["current"] += _spikes(count, unkind.spikes, random) * 0.4
    signals["speed"] = signals["speed"] + random.normal(0.0, sensors["speed_noise"], count)
    signals["voltage"] = signals["voltage"] + random.normal(0.0, _VOLTAGE_NOISE, count)
    for signal, unit, decimals in (
        ("speed", _RPM, 4),
        ("speed_setpoint", _RPM, 4),
        ("current", 1.0, 4),
        ("current_setpoint", 1.0, 4),
        ("voltage", 1.0, 3),
    ):
        signals[signal] = np.round(signals[signal] / unit, decimals) * unit
    kept = _kept(count, unkind.dropped, random)
    return Recording(
        name=name,
        stamps=true.stamps[kept],
        signals={signal: v[kept] for signal, v in signals.items() if not unkind.signals or signal in unkind.signals},
        metadata={"source": "another bench"},
        **origins,
    )


def with_jump(recording: Recording, random: np.random.Generator) -> Recording:
    """The recording as it is before a reader repairs it: the motor's counter jumps somewhere mid-run."""
    counts = stock_constants()["sensors"]["motor_encoder_counts"] / (2.0 * math.pi)
    position = recording.signals["motor_position"].copy()
    position[random.integers(len(position) // 4, 3 * len(position) // 4) :] -= _JUMP / counts
    return replace(recording, signals={**recording.signals, "motor_position": position})


def _spikes(count: int, share: float, random: np.random.Generator) -> np.ndarray:
    """Sizes (n,): zero but at a share of the samples; never at the first, which a recording is measured from."""
    sizes = np.where(random.random(count) < share, random.normal(0.0, 1.0, count), 0.0)
    sizes[0] = 0.0
    return sizes


def _kept(count: int, share: float, random: np.random.Generator) -> np.ndarray:
    """Which rows (n,) the trace holds: some are missing, one to fifty in a row; the first two are there."""
    kept = np.ones(count, bool)
    while share and 1.0 - kept.mean() < share:
        start = int(random.integers(2, count))
        kept[start : start + int(random.integers(1, 50))] = False
    return kept

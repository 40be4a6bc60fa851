"""Recordings that tests make: of the virtual bench, and with other signals than it gave; a twin's of a steady input."""

from dataclasses import replace

import numpy as np

from ema_bench_replay.recording import Recording
from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.twin import Twin
from ema_twin_sim.simulation.virtual_bench import virtual_bench

COMMANDS = ("ramp:0.05", "triangle:0.06:2", "sine:0.05:0.4")


def benched(model, command, seconds, **more):
    """What the virtual bench records of a model under a ``command`` such as ``sine:0.05:2``."""
    return virtual_bench(model, parse_command(command), seconds, **more)


def record(model, commands=COMMANDS, seconds=6.0, seed=1):
    """One recording a command, named run0, run1, …"""
    return [benched(model, text, seconds, seed=seed + k, name=f"run{k}") for k, text in enumerate(commands)]


def sampled(name, time, signals, **more):
    """A recording of signals (n,) at these times (n,) [s]."""
    return Recording(name, np.rint(1e9 * np.asarray(time)).astype(np.int64), signals, **more)


def with_signals(recording, signals, stamps=None):
    """The recording with these signals only, and with other stamps where given."""
    return Recording(
        recording.name,
        recording.stamps if stamps is None else stamps,
        signals,
        motor_angle_origin=recording.motor_angle_origin,
        output_angle_origin=recording.output_angle_origin,
    )


def changed(recording, **signals):
    """The recording with these signals (n,) in place of its own."""
    return replace(recording, signals={**recording.signals, **signals})


def lined(recordings, amplitude, lines=300.0):
    """The recordings of an output encoder that errs within its lines by so much [rad], of so many waves in a radian."""
    shown = [recording.signals["output_position"] for recording in recordings]
    return [
        changed(r, output_position=a + amplitude * np.sin(lines * a)) for r, a in zip(recordings, shown, strict=True)
    ]


def scaled(recording, **factors):
    """The recording with these signals times these factors."""
    return changed(recording, **{name: factor * recording.signals[name] for name, factor in factors.items()})


def driven(model, source, sample, count, period=125_000, first=None):
    """(twin, rows) under a constant sample from a first one: rows is a dict of arrays (count + 1,), by periods [ns]."""
    twin = Twin(model, source)
    rows = [twin.start(first or sample)] + [twin.advance(period, sample) for _ in range(count)]
    return twin, {name: np.array([row[name] for row in rows]) for name in rows[0]}

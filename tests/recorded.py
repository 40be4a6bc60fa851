"""Recordings that tests make: of the virtual bench, and with other signals than it gave."""

import numpy as np

from ema_bench_replay.recording import Recording
from ema_twin_sim.simulation.command import parse_command
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


def scaled(recording, **factors):
    """The recording with these signals times these factors."""
    signals = dict(recording.signals)
    return with_signals(recording, {**signals, **{name: f * signals[name] for name, f in factors.items()}})

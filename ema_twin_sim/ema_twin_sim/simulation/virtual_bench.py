"""The virtual bench: a recording of a model driven by a command, with the bench's sensors and their noise."""

from __future__ import annotations

import math

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import MOTION, Recording

from ..model import Model
from ..plant.layout import BENCH, TWIN
from .command import Command
from .dc_link_check import refuse_command_beyond_link
from .simulate import refuse_without_speed_controller
from .twin import Twin

_RECORDED = (
    *("current", "current_setpoint", "speed", "speed_setpoint", "motor_position", "output_position", "output_command"),
    *("voltage", "direct_current", "phase_current_u", "phase_current_v", "phase_current_w"),
)
"""Signals of which the bench has a sensor, or which its drive tells."""


def virtual_bench(
    model: Model,
    command: Command,
    seconds: float = 20.0,
    *,
    seed: int | None = 0,
    name: str = "",
    step: float | None = None,
    origins: tuple[float, float] = (0.0, 0.0),
) -> Recording:
    """A recording of the model driven by a command, with the sensors' noise (``seed`` None: none).

    It starts at rest, with the drive on, and is sampled with the model's trace period. ``origins`` [rad] are the
    readings of the motor's counter and the output's encoder at the start.
    """
    period = round(model.value("sensors.sample_period") * 1e9)
    count = int(seconds * 1e9 / period + 1e-9) + 1 if math.isfinite(seconds) else 0
    if not 2 <= count <= 50_000_000:
        raise InputError(
            f"--seconds {seconds}: give a duration between two samples and {50_000_000 * period * 1e-9:.0f} s"
        )
    rate = 1e9 / period
    if command.frequency >= 0.5 * rate:
        raise InputError(
            f"command '{command.text}': repeats {command.frequency:g} times a second, and {rate:g} samples a second "
            f"show no more than {0.5 * rate:g}; give a slower one"
        )
    refuse_without_speed_controller(model)
    stamps = np.arange(count, dtype=np.int64) * period
    wanted = command(stamps * 1e-9)
    refuse_command_beyond_link(model, command, stamps * 1e-9)
    column = "speed_setpoint" if command.speed else "output_command"
    bench = np.full((count, len(BENCH)), math.nan)
    bench[:, BENCH.index(column)] = wanted * (model.value("machine.gear_ratio") if command.speed else 1.0)
    twin = Twin(model, "standalone_speed" if command.speed else "standalone", step=step)
    twin.start({column: bench[0, BENCH.index(column)]}, *origins)
    rows = twin.follow(stamps, bench)
    signals = {name: rows[:, k] for k, name in enumerate(TWIN) if name in _RECORDED and not np.isnan(rows[1:, k]).all()}
    if seed is not None:
        signals = with_noise(signals, model, seed)
    motion = {} if model.motion == "rotary" else {MOTION: model.motion}
    return Recording(
        name=name or command.name,
        stamps=stamps,
        signals=signals,
        motor_angle_origin=origins[0],
        output_angle_origin=origins[1],
        metadata={"source": "virtual bench", "model": model.name, "command": command.text, "seed": str(seed), **motion},
    )


def with_noise(signals: dict[str, np.ndarray], model: Model, seed: int) -> dict[str, np.ndarray]:
    """Signals with the sensors' white noise; counters stay whole counts, zero at the first sample."""
    random = np.random.default_rng(seed)
    noisy = dict(signals)
    for name, noise in (("current", "current_noise"), ("speed", "speed_noise")):
        noisy[name] = signals[name] + random.normal(0.0, model.value(f"sensors.{noise}"), len(signals[name]))
    for name in ("motor", "output"):
        count = model.turn / model.value(f"sensors.{name}_encoder_counts")
        position = signals[f"{name}_position"]
        error = np.rint(random.normal(0.0, model.value(f"sensors.{name}_encoder_noise"), len(position)))
        noisy[f"{name}_position"] = np.rint(position / count + error - error[0]) * count
    return noisy

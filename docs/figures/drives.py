"""The averaged drive beside the switching one, on a ramp."""

from __future__ import annotations

from functools import cache

import numpy as np
from matplotlib.figure import Figure

from ema_bench_replay.recording import Recording
from ema_twin_sim.model import load_model
from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.virtual_bench import virtual_bench

from .number import Number
from .style import BLUE, ORANGE, sheet

RAMP = 0.05  # rad/s of the slow shaft
SETTLED = 0.5  # s
MODELS = {"averaged drive": ("polito_bench", BLUE, "-"), "switching drive": ("polito_hf", ORANGE, "--")}


@cache
def run(model: str) -> Recording:
    """Three seconds of the ramp, from rest, without the sensors' noise."""
    return virtual_bench(load_model(model), parse_command(f"ramp:{RAMP}"), 3.0, seed=None)


def numbers() -> dict[str, Number]:
    """What the page quotes of it."""
    settled = {name: run(name).signals["current"][run(name).time > SETTLED] for name, *_ in MODELS.values()}
    averaged, switching = settled["polito_bench"].mean(), settled["polito_hf"].mean()
    return {
        "mean_averaged": Number(1e3 * float(averaged), 1),
        "mean_switching": Number(1e3 * float(switching), 1),
        "means_differ": Number(100.0 * abs(float(switching / averaged) - 1.0), 2),
        "ripple_switching": Number(1e3 * float(settled["polito_hf"].std()), 1),
    }


def draw() -> Figure:
    """The start of the ramp and a settled stretch."""
    figure, axes = sheet(2, height=4.6)
    for axis, (start, end) in zip(axes, ((0.0, 0.3), (1.0, 1.3)), strict=True):
        for label, (name, colour, dashes) in MODELS.items():
            recording = run(name)
            shown = (recording.time >= start) & (recording.time <= end)
            axis.plot(recording.time[shown], recording.signals["current"][shown], dashes, color=colour, label=label)
        axis.set_xlim(start, end)
        axis.set_ylabel("current [A]")
    axes[0].set_title("from rest")
    axes[0].set_ylim(-0.01, 0.29)
    axes[1].set_title("settled, enlarged")
    middle = np.mean(run("polito_bench").signals["current"][run("polito_bench").time > SETTLED])
    axes[1].set_ylim(middle - 0.06, middle + 0.06)
    axes[1].set_xlabel("time [s]")
    axes[0].legend(loc="upper right", ncols=2)
    return figure

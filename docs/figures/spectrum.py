"""The current over orders: a ramp under load with a healthy gearbox, and with each damage."""

from __future__ import annotations

from functools import cache

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.virtual_bench import virtual_bench

from .bench import planetary
from .number import Number
from .style import BLUE, GREY, RED, sheet

RAMP = 0.1  # rad/s of the slow shaft
LOAD = 0.3  # N m at the fast shaft
SETTLED, END = 2.0, 66.0  # s: 126 turns of the motor, which tell 0.726 from 0.75
SAMPLES = 5e-4  # s, a quarter of the trace's: at its 2 ms the sixteenth harmonic of the mesh would fold to order 1.4
PER_TURN = 1024
FLOOR = 7e-4  # mA, below which nothing is drawn
OUTPUT_TOOTH = 45.0 / 62.0
CONDITIONS: dict[str, tuple[str, dict[str, float], float]] = {
    "healthy": ("healthy", {}, 0.0),
    "sun_tooth": ("sun: one tooth at half its stiffness", {"sun_tooth_damage": 0.5}, 2.25),
    "planet_tooth": ("first planet: one tooth at half", {"planet_tooth_damage": 0.5}, 0.75),
    "ring_tooth": ("fixed ring: one tooth at half", {"ring_tooth_damage": 0.5}, 0.75),
    "output_tooth": ("output ring: one tooth at half", {"output_ring_tooth_damage": 0.5}, OUTPUT_TOOTH),
    "sun_runout": ("sun: run-out of 20 µm", {"sun_runout": 2e-5}, 0.75),
    "planet_runout": ("first planet: run-out of 20 µm", {"planet_runout": 2e-5}, 0.75),
    "output_runout": ("output ring: run-out of 20 µm", {"output_ring_runout": 2e-5}, OUTPUT_TOOTH),
}
"""What is said of it, the transmission's constants, and the order at which theory has it."""
NAMED = {
    0.75: ("planet", 0.5, "right"),
    1.0: ("sun", 1.2, "left"),
    2.25: ("tooth of the sun", 3.1, "left"),
    4.0: ("electrical", 5.1, "left"),
    15.0: ("2nd mesh", 14.8, "right"),
    15.75: ("1st mesh", 16.0, "left"),
    31.5: ("2 × 1st mesh", 31.7, "left"),
    45.0: ("3 × 2nd mesh", 44.8, "right"),
    47.25: ("3 × 1st mesh", 47.5, "left"),
}
"""Orders of the spectrum, each with its name, where that stands and on which side of there."""
LOW = (0.25, OUTPUT_TOOTH, 0.75, 1.0, 1.5, 2.25, 3.0)
FITTED = (*LOW, 15.0, 15.75, 31.5, 45.0)


@cache
def ramp(condition: str) -> tuple[np.ndarray, np.ndarray]:
    """(motor angle [rad], current [mA]) once the ramp has settled."""
    model = planetary().with_effect("constant_load", {"torque": LOAD}).with_value("sensors.sample_period", SAMPLES)
    for name, value in CONDITIONS[condition][1].items():
        model = model.with_value(f"transmission.{name}", value)
    recording = virtual_bench(model, parse_command(f"ramp:{RAMP}"), END, seed=None)
    settled = recording.time > SETTLED
    return recording.signals["motor_position"][settled], 1e3 * recording.signals["current"][settled]


def spectrum(condition: str) -> tuple[np.ndarray, np.ndarray]:
    """(orders, amplitudes [mA]): over equal steps of the motor's angle, with a Hann window."""
    angle, current = ramp(condition)
    even = np.arange(angle[0], angle[-1], 2.0 * np.pi / PER_TURN)
    window = np.hanning(len(even))
    values = np.interp(even, angle, current)
    amplitudes = 2.0 * np.abs(np.fft.rfft(window * (values - values.mean()))) / window.sum()
    return np.arange(len(amplitudes)) * PER_TURN / len(even), amplitudes


def amplitudes(condition: str) -> dict[float, float]:
    """Amplitudes [mA] at the orders that have names, all fitted at once."""
    angle, current = ramp(condition)
    waves = [wave(order * angle) for order in FITTED for wave in (np.sin, np.cos)]
    parts = np.linalg.lstsq(np.column_stack([np.ones_like(angle), *waves]), current, rcond=None)[0][1:]
    return dict(zip(FITTED, np.hypot(parts[::2], parts[1::2]), strict=True))


def slow_numbers() -> dict[str, Number]:
    """What the page quotes of it: each damage at its order, beside the healthy gearbox."""
    healthy = amplitudes("healthy")
    found = {
        "healthy_low": Number(max(healthy[order] for order in LOW), 3),
        "healthy_15": Number(healthy[15.0], 3),
        "healthy_15_75": Number(healthy[15.75], 1),
        "healthy_31_5": Number(healthy[31.5], 1),
        "healthy_45": Number(healthy[45.0], 1),
    }
    for condition, (_, _, order) in CONDITIONS.items():
        if condition != "healthy":
            at = amplitudes(condition)
            found[f"{condition}_at"] = Number(at[order], 2)
            found[f"{condition}_15"] = Number(at[15.0], 2)
    return found | {
        "sun_runout_twice": Number(amplitudes("sun_runout")[1.5], 2),
        "planet_runout_twice": Number(amplitudes("planet_runout")[1.5], 2),
    }


def _line(axis: Axes, condition: str, highest: float, colour: str, width: float, label: str | None = None) -> None:
    orders, sizes = spectrum(condition)
    shown = (orders > 0.1) & (orders < highest)
    axis.plot(orders[shown], np.maximum(sizes[shown], FLOOR), color=colour, lw=width, label=label)
    axis.set_yscale("log")


def draw() -> Figure:
    """The healthy gearbox over all orders, those with a name named."""
    figure, (axis,) = sheet(height=4.2)
    _line(axis, "healthy", 50.0, BLUE, 1.0)
    for order, (name, at, side) in NAMED.items():
        axis.axvline(order, color=GREY, lw=0.7, ls=":")
        axis.text(at, 2e4, f"{name} {order:g}", rotation=90, ha=side, va="top", fontsize=10)
    axis.set_ylim(1e-3, 3e4)
    axis.set_yticks([1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0])
    axis.set_xlim(-3.5, 50.0)
    axis.set_xticks([0, 10, 20, 30, 40, 50])
    axis.set_ylabel("amplitude of the current [mA]")
    axis.set_xlabel("order [cycles per turn of the motor]")
    return figure


def draw_damages() -> Figure:
    """Each damage over the low orders, the healthy gearbox behind it, the order of theory marked."""
    figure, axes = sheet(7, height=9.2, sharex=True, sharey=True)
    damages = [(name, *told) for name, told in CONDITIONS.items() if name != "healthy"]
    for axis, (condition, words, _, order) in zip(axes, damages, strict=True):
        axis.axvline(order, color=RED, lw=5.0, alpha=0.25)
        _line(axis, "healthy", 3.4, GREY, 1.0, "healthy")
        _line(axis, condition, 3.4, BLUE, 1.2, "damaged")
        axis.set_title(f"{words}: order {order:.3g}", fontsize=10.5)
    axes[0].set_ylim(1.2 * FLOOR, 200.0)
    axes[0].set_yticks([1e-3, 0.1, 10.0])
    axes[0].set_xlim(0.1, 3.4)
    axes[0].set_xticks([0.25, 0.75, 1.0, 1.5, 2.25, 3.0], ["0.25", "0.75", "1", "1.5", "2.25", "3"])
    axes[3].set_ylabel("amplitude of the current [mA]")
    axes[-1].set_xlabel("order [cycles per turn of the motor]")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper right", ncols=2, frameon=False)
    return figure

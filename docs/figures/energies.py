"""Where the energy of a run went: drive, windings, teeth, friction, load."""

from __future__ import annotations

from functools import cache

import numpy as np
from matplotlib.figure import Figure

from ema_twin_sim.model import load_model
from ema_twin_sim.simulation.twin import Twin

from .bench import follow
from .number import Number
from .style import BLUE, GREEN, GREY, ORANGE, PURPLE, RED, SKY, sheet

LOAD = 1.0  # N m at the fast shaft
SPEED = 10.0  # rad/s of the motor
SECONDS = 1.0
TO = {
    "load": ("load", GREEN),
    "output_dry": ("dry friction, output", GREY),
    "output_mesh_friction": ("teeth of the output ring", BLUE),
    "ring_mesh_friction": ("teeth of the fixed ring", BLUE),
    "sun_mesh_friction": ("teeth of the sun", BLUE),
    "mesh_damping": ("damping of the teeth", SKY),
    "motor_viscous": ("viscous friction, motor", GREY),
    "motor_dry": ("dry friction, motor", GREY),
    "winding": ("windings and switches", ORANGE),
    "stored": ("stored", PURPLE),
    "stiffness_change": ("put in as stiffness changes", PURPLE),
    "link": ("out of the DC link", RED),
}
"""What energy went to, and the last two: where it came from; with its colour."""


@cache
def run(load: float) -> dict[str, float]:
    """Energies [J] of a settled second of polito_hff turning against a load [N m]; they balance (test_energy.py)."""
    model = load_model("polito_hff").with_effect("constant_load", {"torque": load})
    twin = Twin(model, "setpoint", accounting=True)
    twin.start({"speed": SPEED, "speed_setpoint": SPEED, "current": 0.3})
    follow(twin, 0.5, 2e-3, speed_setpoint=SPEED)
    before = twin.energies()
    follow(twin, SECONDS, 2e-3, speed_setpoint=SPEED)
    after = twin.energies()
    went = {name: after.booked[name] - before.booked[name] for name in after.booked}
    return went | {"stored": sum(after.stored.values()) - sum(before.stored.values())}


def numbers() -> dict[str, Number]:
    """What the page quotes of it."""
    found: dict[str, Number] = {}
    for way, load in (("raising", LOAD), ("lowering", -LOAD)):
        went = run(load)
        teeth = sum(went[f"{mesh}_mesh_friction"] for mesh in ("sun", "ring", "output"))
        found |= {
            f"{way}_link": Number(went["link"], 1),
            f"{way}_load": Number(went["load"], 1),
            f"{way}_teeth": Number(teeth, 1),
            f"{way}_winding": Number(went["winding"], 1),
            f"{way}_stiffness": Number(went["stiffness_change"], 2),
            f"{way}_damping": Number(went["mesh_damping"], 3),
        }
    return found


def draw() -> Figure:
    """Bars, one an entry, for a load that is raised and one that is lowered."""
    figure, axes = sheet(1, 2, height=4.4, sharey=True)
    for axis, load, title in zip(axes, (LOAD, -LOAD), ("raising a load", "lowering it"), strict=True):
        went = run(load)
        values = [went[name] for name in TO]
        places = np.arange(len(values))
        axis.barh(places, values, color=[colour for _, colour in TO.values()], height=0.72)
        for place, value in zip(places, values, strict=True):
            side = "right" if value < -0.05 else "left"
            text = f" {value:.1f} ".replace("-", "−") if abs(value) >= 0.05 else " 0 "
            axis.text(value, place, text, va="center", ha=side, fontsize=10)
        axis.set_title(title)
        axis.axvline(0.0, color="black", lw=0.8)
        axis.grid(axis="y", visible=False)
        axis.set_axisbelow(True)
        low, high = min(min(values), 0.0), max(values)
        axis.set_xlim(low - (0.65 * (high - low) if low < 0.0 else 0.0), high + 0.28 * (high - low))
    axes[0].set_yticks(np.arange(len(TO)), [words for words, _ in TO.values()])
    figure.supxlabel("energy in one second [J]", fontsize=11)
    return figure

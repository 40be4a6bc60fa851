"""Phase currents of the switching drive under load: healthy, and with shorted turns in one phase."""

from __future__ import annotations

from functools import cache

import numpy as np
from matplotlib.figure import Figure

from ema_twin_sim.model import load_model
from ema_twin_sim.plant.layout import TWIN
from ema_twin_sim.simulation.twin import Twin

from .bench import follow
from .number import Number
from .style import BLUE, GREY, ORANGE, PURPLE, sheet

SHORT = 0.3  # of phase u's turns
LOAD = 3.0  # N m at the fast shaft
SPEED = 6.2  # rad/s of the motor, of the ramp of 0.05 rad/s
PAIRS = 4.0
INTERVAL = 5e-5  # s
EVERY = 7  # of them is drawn


@cache
def run(short: float) -> dict[str, np.ndarray]:
    """Signals over one turn of the motor, the speed controller settled."""
    model = load_model("polito_hf").with_value("machine.active_turns_u", 1.0 - short)
    twin = Twin(model.with_effect("constant_load", {"torque": LOAD}), "setpoint")
    twin.start({"speed": SPEED, "speed_setpoint": SPEED, "current": 1.7})
    follow(twin, 0.5, 2e-3, speed_setpoint=SPEED)
    rows = follow(twin, 2.0 * np.pi / SPEED, INTERVAL, speed_setpoint=SPEED)[1:]
    return {name: rows[:, k] for k, name in enumerate(TWIN)}


def order(signal: np.ndarray, angle: np.ndarray, cycles: float) -> float:
    """Amplitude of a signal at an order."""
    return float(2.0 * np.abs(np.mean(signal * np.exp(-1j * cycles * angle))))


def numbers() -> dict[str, Number]:
    """What the page quotes of it."""
    healthy, shorted = run(0.0), run(SHORT)
    ripple = {
        name: order(of["current"], of["motor_position"], 2.0 * PAIRS) / of["current"].mean()
        for name, of in (("healthy", healthy), ("shorted", shorted))
    }
    return {
        "short_mean": Number(float(shorted["current"].mean() / healthy["current"].mean()), 3),
        "short_theory": Number(1.0 / (1.0 - SHORT / 3.0), 3),
        "short_ripple": Number(100.0 * ripple["shorted"], 1),
        "short_ripple_healthy": Number(100.0 * ripple["healthy"], 1),
    }


def draw() -> Figure:
    """Three phases over one electrical turn, then the quadrature current over a turn of the motor."""
    figure, axes = sheet(3, height=6.4)
    shorts = ((0.0, "healthy"), (SHORT, f"{100 * SHORT:.0f} % of phase u's turns shorted"))
    for axis, (short, title) in zip(axes, shorts, strict=False):
        of = run(short)
        turns = PAIRS * (of["motor_position"] - of["motor_position"][0]) / (2.0 * np.pi)
        shown = (turns <= 1.0) & (np.arange(len(turns)) % EVERY == 0)
        for phase, colour in zip("uvw", (BLUE, ORANGE, GREY), strict=True):
            axis.plot(turns[shown], of[f"phase_current_{phase}"][shown], color=colour, lw=0.9, label=f"phase {phase}")
        axis.set_title(title)
        axis.set_ylabel("phase current [A]")
        axis.set_ylim(-3.2, 3.2)
        axis.set_xlim(0.0, 1.0)
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper right", ncols=3, frameon=False)
    axes[1].set_xlabel("electrical turns [1]")
    for short, colour, label in ((0.0, GREY, "healthy"), (SHORT, PURPLE, "shorted")):
        of = run(short)
        turns = (of["motor_position"] - of["motor_position"][0]) / (2.0 * np.pi)
        axes[2].plot(turns[:: 3 * EVERY], of["current"][:: 3 * EVERY], color=colour, lw=1.2, label=label)
    axes[2].set_title("as the drive reports it")
    axes[2].set_ylabel("quadrature\ncurrent [A]")
    axes[2].set_xlabel("turns of the motor [1]: eight waves in one")
    axes[2].set_xlim(0.0, 1.0)
    axes[2].set_ylim(1.45, 2.25)
    axes[2].legend(loc="lower left", ncols=2, borderpad=0.2)
    return figure

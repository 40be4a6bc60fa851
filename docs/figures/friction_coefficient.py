"""Coefficient of friction of the teeth over speed, by the three laws, with the bound of two of them."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FormatStrFormatter, NullLocator

from ema_twin_sim.plant.planetary.friction_coefficient import (
    BOUNDARY_LUBRICATION,
    ISO_TR_14179_2,
    ISO_TS_6336_4,
    dynamic_viscosity,
    friction_coefficient,
)
from ema_twin_sim.plant.planetary.geometry import RING_MESH
from ema_twin_sim.plant.planetary.mesh_table import mean_arms
from ema_twin_sim.plant.planetary.quasi_static import sliding_speeds, static_forces, sum_speeds

from .bench import GEARING, TABLE, planetary
from .number import Number
from .style import BLUE, FAINT, GREY, ORANGE, RED, sheet

LOADS = (2.0, 20.0, 200.0)  # N/mm
RAMPS = (0.01, 0.1)  # rad/s of the slow shaft, the thesis's slowest and fastest
SMOOTH = 1e-7  # m, the script's roughness


@cache
def viscosity() -> float:
    """Dynamic viscosity [Pa s] of the script's oil at the model's temperature."""
    return dynamic_viscosity(planetary().value("transmission.lubricant_temperature"))


def coefficient(law: int, load: float, speed: float, roughness: float | None = None) -> float:
    """Coefficient at a line ``load`` [N/mm] and sum of rolling speeds [m/s] of a ring mesh of the bench."""
    rough = planetary().value("transmission.roughness") if roughness is None else roughness
    radius = GEARING.meshes[RING_MESH].equivalent_radius
    return float(friction_coefficient(law, 0.0, 1e3 * load, speed, radius, viscosity(), rough))


def ramp_speeds() -> np.ndarray:
    """Sums of rolling speeds [m/s] of the ring mesh at the slowest and the fastest ramp."""
    return np.array([sum_speeds(GEARING, ramp * GEARING.ratio)[RING_MESH] for ramp in RAMPS])


def line_load(torque: float) -> float:
    """Line load [N/mm] of a ring mesh under a ``torque`` [N m] on the sun, without friction."""
    return 1e-3 * abs(float(static_forces(GEARING, torque)[RING_MESH])) / GEARING.face_width


def bound_speed(law: int, load: float, roughness: float | None = None) -> float:
    """Sum of rolling speeds [m/s] below which the bound holds, by halving."""
    low, high = 1e-12, 1e3
    for _ in range(100):
        middle = math.sqrt(low * high)
        held = coefficient(law, load, middle, roughness) >= BOUNDARY_LUBRICATION
        low, high = (middle, high) if held else (low, middle)
    return middle


def script_coefficient() -> float:
    """What the script's formula (f_att2) makes at 0.01 rad/s: no force, no radius, metres for micrometres."""
    rolling = 2.0 * 0.01 * GEARING.ratio * 39.5e-3 * math.sin(GEARING.pressure_angle)
    return 0.048 * (1.0 / 0.018 / rolling) ** 0.2 * viscosity() ** -0.05 * SMOOTH**0.25


def numbers() -> dict[str, Number]:
    """What the page quotes of it."""
    load = line_load(0.3)
    slow, fast = ramp_speeds()
    return {
        "viscosity": Number(1e3 * viscosity(), 1),
        "line_load": Number(load, 1),
        "ring_force": Number(1e3 * load * GEARING.face_width),
        "rolling_slow": Number(slow, 3),
        "rolling_fast": Number(fast, 2),
        "script_coefficient": Number(script_coefficient(), 4),
        "corrected_coefficient": Number(coefficient(ISO_TR_14179_2, load, slow, SMOOTH), 3),
        "tr_slow": Number(coefficient(ISO_TR_14179_2, load, slow), 3),
        "tr_fast": Number(coefficient(ISO_TR_14179_2, load, fast), 3),
        "ts_slow": Number(coefficient(ISO_TS_6336_4, load, slow), 3),
        "ts_fast": Number(coefficient(ISO_TS_6336_4, load, fast), 3),
        "tr_bound": Number(1e3 * bound_speed(ISO_TR_14179_2, load), 1),
        "tr_bound_smooth": Number(1e6 * bound_speed(ISO_TR_14179_2, load, SMOOTH)),
        "ts_bound": Number(1e3 * bound_speed(ISO_TS_6336_4, load)),
    }


def draw() -> Figure:
    """Both standards at three loads, the constant, the bound; the ramps' speeds shaded."""
    figure, (axis,) = sheet(height=4.6)
    speeds = np.geomspace(1e-4, 10.0, 241)
    slow, fast = ramp_speeds()
    axis.axvspan(slow, fast, color=FAINT, label="ramps, 0.01 to 0.1 rad/s")
    for law, name, colour, dashes in (
        (ISO_TR_14179_2, "ISO/TR 14179-2, 3.31", BLUE, "-"),
        (ISO_TS_6336_4, "ISO/TS 6336-4, 3.32", ORANGE, "--"),
    ):
        for load in LOADS:
            values = [coefficient(law, load, speed) for speed in speeds]
            axis.plot(speeds, values, dashes, color=colour, label=name if load == LOADS[0] else None)
            axis.text(11.0, values[-1], f"{load:g} N/mm", color=colour, va="center", fontsize=10)
    axis.axhline(planetary().value("transmission.friction_coefficient"), color=GREY, label="constant: dry, printed")
    axis.axhline(BOUNDARY_LUBRICATION, color=RED, ls=":", lw=2.4, label="bound of both standards")
    axis.set_xscale("log")
    axis.set_yscale("log")
    axis.set_ylim(0.022, 0.23)
    axis.set_xlim(speeds[0], speeds[-1])
    axis.yaxis.set_major_locator(FixedLocator([0.03, 0.05, 0.1, 0.2]))
    axis.yaxis.set_minor_locator(NullLocator())
    axis.yaxis.set_major_formatter(FormatStrFormatter("%g"))
    axis.set_ylabel("coefficient of friction [1]")
    axis.set_xlabel("sum of both flanks' rolling speeds [m/s]")
    arms = mean_arms(TABLE)
    sliding = float(sliding_speeds(GEARING, arms, 1.0)[RING_MESH] / sum_speeds(GEARING, 1.0)[RING_MESH])
    top = axis.secondary_xaxis("top", functions=(lambda v: v * sliding, lambda v: v / sliding))
    top.set_xlabel("mean sliding speed of the ring mesh [m/s]")
    figure.legend(*axis.get_legend_handles_labels(), loc="outside lower center", ncols=2, frameon=False)
    return figure

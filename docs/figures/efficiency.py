"""Efficiency of the train, forward and back-driven: reckoned in three ways, self-locking, a map of load and speed."""

from __future__ import annotations

from functools import cache

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter, NullFormatter

from ema_twin_sim.plant.planetary.friction_coefficient import ISO_TR_14179_2
from ema_twin_sim.plant.planetary.geometry import SUN_MESH
from ema_twin_sim.plant.planetary.position_balance import (
    PositionBalance,
    all_positions,
    first_locking_coefficient,
    position_balance,
)
from ema_twin_sim.plant.planetary.quasi_static import (
    ToothFriction,
    balance,
    efficiencies,
    self_locking_coefficient,
    static_forces,
)
from ema_twin_sim.simulation.twin import Twin

from .bench import GEARING, TABLE, follow, planetary, teeth_alone
from .friction_coefficient import viscosity
from .number import Number
from .style import BLUE, GREY, ORANGE, RED, sheet

LOAD = 0.5  # N m at the fast shaft
SPEED = 2.0  # rad/s of the sun, of the running train: slow, so that the load stays even
COEFFICIENTS = (0.05, 0.1, 0.15, 0.2, 0.25, 0.3)
USUAL = 0.1  # of the model file
POSITIONS = 500


@cache
def in_every_position(coefficient: float, load: float) -> PositionBalance:
    """The train in balance in every position, raising a load or (negative) driven by it."""
    return position_balance(GEARING, TABLE, np.full(3, coefficient), load, all_positions(GEARING, POSITIONS))


def by_mean_forces(coefficient: float, output_drives: bool) -> float:
    """Efficiency of the balance of mean forces."""
    return balance(GEARING, TABLE, ToothFriction(constant=coefficient), 1.0, 1.0, output_drives).efficiency


@cache
def running(coefficient: float, load: float) -> float:
    """Efficiency of the integrated train: work and losses booked over one turn of the sun.

    A strong brake on the motor, and the current that overcomes it, hold the speed.
    """
    brake = 2.0  # N m
    model = teeth_alone(coefficient).with_effect("constant_load", {"torque": load})
    model = model.with_effect("viscous_friction", {"coefficient": brake / SPEED})
    torque = float(in_every_position(coefficient, load).sun_torque.mean())
    current = (torque + brake) / model.value("machine.torque_constant")
    twin = Twin(model, "current", accounting=True)
    twin.start({"current": current, "speed": SPEED})
    follow(twin, 0.3, 1e-3, current=current)
    before = twin.energies().booked
    follow(twin, 2.0 * np.pi / SPEED, 1e-3, current=current)
    booked = {name: energy - before[name] for name, energy in twin.energies().booked.items()}
    lost = booked["mesh_damping"] + sum(booked[f"{mesh}_mesh_friction"] for mesh in ("sun", "ring", "output"))
    done = abs(booked["load"])
    return done / (done + lost) if load > 0.0 else 1.0 - lost / done


def lets_go(coefficient: float) -> bool:
    """Whether a load still turns the integrated train after two seconds, with nothing but a weak brake on its motor."""
    model = teeth_alone(coefficient).with_effect("constant_load", {"torque": -LOAD})
    twin = Twin(model.with_effect("viscous_friction", {"coefficient": 0.1}), "current")
    twin.start({"current": 0.0, "speed": 0.0})
    follow(twin, 2.0, 1e-3, current=0.0)
    before = twin.wheels().output_angle
    follow(twin, 1.0, 1e-3, current=0.0)
    return (twin.wheels().output_angle - before) * GEARING.ratio > 0.05


def smallest(locked: object, rounds: int, low: float = 0.05, high: float = 0.35) -> float:
    """The smallest coefficient of friction at which ``locked`` (a function of it) holds, by halving."""
    for _ in range(rounds):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if locked(middle) else (middle, high)  # type: ignore[operator]
    return high


@cache
def locking() -> dict[str, float]:
    """Smallest coefficients at which the output cannot drive: mean forces, mean of all positions, first position."""
    return {
        "forces": self_locking_coefficient(GEARING, TABLE),
        "mean": smallest(lambda mu: in_every_position(mu, -LOAD).sun_torque.mean() >= 0.0, 14),
        "first": first_locking_coefficient(GEARING, TABLE, POSITIONS),
    }


@cache
def running_locks() -> float:
    """Smallest coefficient at which the integrated train stops under its load."""
    return smallest(lambda mu: not lets_go(mu), 8, 0.1, 0.3)


def numbers() -> dict[str, Number]:
    """What the page quotes of it, but for the integrated train."""
    forward, backward = in_every_position(USUAL, LOAD), in_every_position(USUAL, -LOAD)
    losses = balance(GEARING, TABLE, ToothFriction(constant=USUAL), LOAD).loss_shares
    forces = GEARING.sun_radius * 3.0 * static_forces(GEARING, 1.0)
    by_standard = ToothFriction(ISO_TR_14179_2, 0.0, viscosity(), planetary().value("transmission.roughness"))
    found = {
        "forward_forces": by_mean_forces(USUAL, False),
        "backward_forces": by_mean_forces(USUAL, True),
        "forward_positions": forward.efficiency,
        "backward_positions": backward.efficiency,
        "locking_forces": locking()["forces"],
        "locking_mean": locking()["mean"],
        "locking_first": locking()["first"],
        "standard_slow": balance(GEARING, TABLE, by_standard, 0.3, 1.24).efficiency,
        "standard_fast": balance(GEARING, TABLE, by_standard, 0.3, 12.4).efficiency,
    }
    return {name: Number(value, 3) for name, value in found.items()} | {
        "ring_losses": Number(100.0 * float(losses[1:].sum())),
        "sun_wrong_way": Number(100.0 * float(np.mean(forward.forces[:, SUN_MESH] < 0.0))),
        "force_ring": Number(float(forces[1])),
        "force_output": Number(float(forces[2])),
    }


def slow_numbers() -> dict[str, Number]:
    """What the page quotes of the integrated train."""
    return {
        "forward_running": Number(running(USUAL, LOAD), 3),
        "backward_running": Number(running(USUAL, -LOAD), 3),
        "locking_running": Number(running_locks(), 2),
    }


def draw() -> Figure:
    """Efficiency over the coefficient of friction, forward and back-driving."""
    figure, (axis,) = sheet(height=4.7)
    fine = np.linspace(0.0, 0.33, 67)
    coarse = np.linspace(0.0, 0.33, 23)
    for load, colour, way in ((LOAD, BLUE, "forward"), (-LOAD, ORANGE, "back-driven")):
        means = [by_mean_forces(mu, load < 0.0) for mu in fine]
        axis.plot(fine, means, ":", color=colour, label=f"{way}: mean forces")
        everywhere = [in_every_position(float(mu), load).efficiency for mu in coarse]
        axis.plot(coarse, everywhere, color=colour, label=f"{way}: every position")
        ran = [running(mu, load) for mu in COEFFICIENTS]
        axis.plot(COEFFICIENTS, ran, "o", color=colour, mfc="white", mew=1.6, label=f"{way}: the running train")
    axis.axhline(0.0, color=GREY, lw=1.0)
    marks = (("first", "first position locks"), ("mean", "mean of positions locks"), ("forces", "mean forces lock"))
    for row, (name, words) in enumerate(marks):  # the leftmost highest, so that no line crosses words
        at, height = locking()[name], -0.26 - 0.15 * row
        axis.plot([at, at], [0.0, height], color=RED, lw=1.0)
        axis.plot(at, 0.0, "v", color=RED, ms=6)
        axis.text(at - 0.004, height, f"{words}: {at:.3f}", color=RED, ha="right", va="bottom")
    axis.set_ylim(-0.68, 1.02)
    axis.set_xlim(0.0, 0.33)
    axis.set_ylabel("efficiency [1]")
    axis.set_xlabel("coefficient of friction of the teeth [1]")
    figure.legend(*axis.get_legend_handles_labels(), loc="outside upper center", ncols=2, frameon=False)
    return figure


def draw_map() -> Figure:
    """Efficiency over load and speed by ISO/TR 14179-2, forward and back-driving."""
    figure, axes = sheet(1, 2, height=3.6, sharey=True)
    torques, speeds = np.geomspace(0.05, 5.0, 25), np.geomspace(1.0, 100.0, 25)
    friction = ToothFriction(ISO_TR_14179_2, 0.0, viscosity(), planetary().value("transmission.roughness"))
    levels = np.arange(0.45, 0.951, 0.05)
    for axis, output_drives, title in zip(axes, (False, True), ("forward", "back-driven"), strict=True):
        driving = torques * (GEARING.ratio if output_drives else 1.0)
        values = efficiencies(GEARING, TABLE, friction, driving, speeds, output_drives)
        axis.contourf(speeds, torques, values, levels, cmap="cividis", extend="both")
        lines = axis.contour(speeds, torques, values, levels, colors="white", linewidths=0.8)
        axis.clabel(lines, lines.levels[::2], fmt="%.2f", fontsize=10)
        axis.set_xscale("log")
        axis.set_yscale("log")
        for ticks in (axis.xaxis, axis.yaxis):
            ticks.set_major_formatter(FormatStrFormatter("%g"))
            ticks.set_minor_formatter(NullFormatter())
        axis.grid(False)
        axis.set_title(title)
    figure.supxlabel("speed of the sun [rad/s]", fontsize=11)
    axes[0].set_ylabel("driving torque at the fast shaft [N m]")
    return figure

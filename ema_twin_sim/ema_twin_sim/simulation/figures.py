"""Quantities derived from a model's constants: figures of its gearbox and drive, and its integration steps."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..model import Model
from ..plant.planetary.geometry import Gearing
from ..plant.planetary.mesh_table import AHEAD, ENTERING, mean_stiffness
from ..plant.planetary.position_balance import first_locking_coefficient
from ..plant.planetary.quasi_static import Balance, balance, self_locking_coefficient
from ..plant.planetary.torsional_stiffness import torsional_stiffness
from ..plant.switching.dc_link import highest_speed
from .assembly import Assembly, assemble
from .dc_link_check import allowed_speed, holding_current
from .fidelity import gearing_of, usual_step
from .longest_step import longest_step
from .lumped_train import TYPICAL_SPEED, TYPICAL_TORQUE, tooth_friction


@dataclass(frozen=True)
class Figure:
    """A number with unit, or words if there is none; ``note`` gives the conditions."""

    name: str
    value: float | str
    unit: str = "1"
    note: str = ""

    def as_json(self) -> dict[str, object]:
        """Content for ``info --json``."""
        return {"name": self.name, "value": self.value, "unit": self.unit, "note": self.note}


def figures(model: Model) -> list[Figure]:
    """The figures of a model's transmission and drive; none for an averaged drive and a rigid transmission."""
    assembly = assemble(model)
    found = []
    if assembly.fine.planetary:
        found += _of_the_gearbox(model, assembly)
    if assembly.fine.switching:
        found += _of_the_drive(model, assembly)
    longest, _, _ = longest_step(assembly)
    if math.isfinite(longest):
        found.append(Figure("longest safe step", longest, "s"))
        found.append(Figure("step it is run at", usual_step(assembly.fine), "s"))
    return found


def _of_the_gearbox(model: Model, assembly: Assembly) -> list[Figure]:
    gearing, table, train = gearing_of(model), assembly.fine.table, assembly.fine.train[0]
    g = gearing
    teeth = f"sun {g.sun_teeth}, planets {g.planet_teeth} and {g.second_planet_teeth}, fixed ring {g.ring_teeth}, "
    found = [
        Figure("teeth", f"{teeth}output ring {g.output_ring_teeth}"),
        Figure("ratio", g.ratio),
        Figure("module", g.module, "m"),
        Figure("centre distance", g.centre_distance, "m"),
        Figure("operating pressure angle", g.pressure_angle, "rad", f"{math.degrees(g.pressure_angle):.4g}°"),
    ]
    found += [Figure(f"contact ratio, {mesh.name}", mesh.contact_ratio) for mesh in g.meshes]
    both = table[:, :-1, [ENTERING, AHEAD]].sum(axis=2)
    for mesh, mean, least, most in zip(
        g.meshes, mean_stiffness(table), both.min(axis=1), both.max(axis=1), strict=True
    ):
        note = f"mean of a cycle, {least * 1e-6:.3g} to {most * 1e-6:.3g} MN/m"
        found.append(Figure(f"mesh stiffness, {mesh.name}", float(mean), "N/m", note))
    fast, slow = torsional_stiffness(gearing, table)
    shaft = float(train["shaft_stiffness"])
    if shaft > 0.0:
        fast = 1.0 / (1.0 / fast + 1.0 / shaft)
        slow = fast * g.ratio**2
    plant = assembly.plant[0]
    swing = math.sqrt(fast * (1.0 / plant["motor_inertia"] + 1.0 / plant["output_inertia"])) / (2.0 * math.pi)
    found += [
        Figure("torsional stiffness at the fast shaft", fast, "N m/rad", "output held"),
        Figure("torsional stiffness at the slow shaft", slow, "N m/rad", "sun held"),
        Figure("natural frequency of motor against output", swing, "Hz"),
    ]
    return [*found, *_of_the_teeth(gearing, assembly)]


def _of_the_teeth(gearing: Gearing, assembly: Assembly) -> list[Figure]:
    """Efficiency and self-locking with the model's tooth friction; bearings and seals are not included."""
    table = assembly.fine.table
    friction = tooth_friction(assembly.fine.train[0])
    forward = balance(gearing, table, friction, TYPICAL_TORQUE, TYPICAL_SPEED)
    backward = balance(gearing, table, friction, TYPICAL_TORQUE * abs(gearing.ratio), TYPICAL_SPEED, True)
    locks = backward.efficiency <= 0.0
    at = _conditions(forward)
    first, limit = first_locking_coefficient(gearing, table), self_locking_coefficient(gearing, table)
    slow = "may" if float(backward.coefficients.max()) >= first else "no"
    return [
        Figure("efficiency, motor driving", forward.efficiency, "1", at),
        Figure("efficiency, output driving", "none" if locks else backward.efficiency, "1", at),
        Figure("self-locking", "yes" if locks else slow, "1", "whether the output cannot turn the motor"),
        Figure(
            "self-locking in some position from a friction coefficient of",
            first if math.isfinite(first) else "none",
            "1",
            "where a slow load may stop: the number to design by",
        ),
        Figure(
            "self-locking by mean forces from a friction coefficient of",
            limit if math.isfinite(limit) else "none",
            "1",
            "from where it surely locks",
        ),
    ]


def _conditions(balanced: Balance) -> str:
    low, high = balanced.coefficients.min(), balanced.coefficients.max()
    coefficient = f"{low:.3g}" if math.isclose(low, high) else f"{low:.3g} to {high:.3g}"
    at = f"{TYPICAL_TORQUE:g} N m and {TYPICAL_SPEED:g} rad/s of the sun"
    return f"teeth alone, by mean forces, friction {coefficient}, at {at}"


def _of_the_drive(model: Model, assembly: Assembly) -> list[Figure]:
    winding = assembly.fine.winding[0]
    link = f"DC link of {winding['dc_link_voltage']:.4g} V"
    speed = allowed_speed(assembly)
    torque = min(model.value("drive.torque_limit"), model.value("drive.current_limit") * winding["torque_constant"])
    loaded = highest_speed(winding, torque / float(winding["torque_constant"]))
    current = holding_current(assembly, speed)
    return [
        Figure("highest speed, not loaded", highest_speed(winding, 0.0), "rad/s", link),
        Figure("highest speed against its friction", speed, "rad/s", f"{link}, {current:.3g} A"),
        Figure("highest speed at the torque limit", loaded, "rad/s", f"{link}, {torque:.4g} N m"),
    ]

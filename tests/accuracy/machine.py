"""The other bench's constants: those of the stock model's files, and one machine of that make, a little off."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
import yaml

from ema_twin_sim.model import Model

_MODELS = Path(__file__).resolve().parents[2] / "config" / "models"


DRAWN = (
    *("motor_inertia", "output_inertia", "motor_viscous", "output_viscous", "motor_level", "output_level"),
    *("current_lag", "filter", "smoothing"),
)
"""Constants that are off on any machine of a make."""


@dataclass(frozen=True)
class Machine:
    """One machine: what the stock model says of the bench, or what a bench truly is. SI, at the fast shaft."""

    motor_inertia: float  # with the gearbox
    output_inertia: float
    torque_constant: float
    motor_viscous: float
    output_viscous: float
    motor_level: float
    output_level: float
    current_lag: float
    filter: float
    smoothing: float
    gear_frequency: float = 500.0  # Hz at which the gearbox rings: stiff
    gear_damping: float = 0.2  # of critical
    bristle_travel: float = 6e-4  # rad of the motor over which friction turns round: next to none
    elastic_share: float = 0.5  # of that travel, which springs back wholly; below 0: a plain LuGre bristle
    gear_ratio: float = 0.0  # 0: the stock model's
    speed_gain: float = 1.0  # times the stock model's
    cycle: int = 4  # steps of the plant in a control cycle: 62.5 us

    @property
    def gear(self) -> tuple[float, float]:
        """(stiffness [N m/rad], damping [N m s/rad]) of the gearbox."""
        return spring(self.gear_frequency, self.gear_damping, self.motor_inertia, self.output_inertia)


def spring(frequency: float, damping: float, *inertias: float) -> tuple[float, float]:
    """(stiffness [N m/rad], damping [N m s/rad]) of a coupling with which two inertias ring at ``frequency`` [Hz].

    ``damping`` is over the critical one.
    """
    reduced = 1.0 / sum(1.0 / inertia for inertia in inertias)
    stiffness = reduced * (2.0 * math.pi * frequency) ** 2
    return stiffness, 2.0 * damping * math.sqrt(stiffness * reduced)


@cache
def stock_constants() -> dict[str, dict[str, float]]:
    """The stock model's numbers by part and name, read from its files; ``effects`` sums each effect over its sides."""
    model = yaml.safe_load((_MODELS / "polito_bench.yaml").read_text("utf-8"))
    base = yaml.safe_load((_MODELS / model["base"]).read_text("utf-8"))
    parts = {
        part: {name: entry["value"] for name, entry in base[part].items() if isinstance(entry, dict)}
        for part in ("machine", "drive", "sensors")
    }
    first = {"viscous_friction": "coefficient", "coulomb_friction": "torque"}
    parts["effects"] = {
        f"{entry['options']['side']}_{entry['effect']}": entry["parameters"][first[entry["effect"]]]
        for entry in model["effects"].values()
    }
    return parts


def stock_machine() -> Machine:
    """The machine that the stock model describes, on this bench's stiff gearbox."""
    parts = stock_constants()
    machine, drive, effects = parts["machine"], parts["drive"], parts["effects"]
    return Machine(
        motor_inertia=machine["motor_inertia"] + machine["gearbox_inertia"],
        output_inertia=machine["output_inertia"],
        torque_constant=machine["torque_constant"],
        motor_viscous=effects["motor_viscous_friction"],
        output_viscous=effects["output_viscous_friction"],
        motor_level=effects["motor_coulomb_friction"],
        output_level=effects["output_coulomb_friction"],
        current_lag=drive["current_lag"],
        filter=drive["speed_setpoint_filter"],
        smoothing=parts["sensors"]["speed_smoothing"],
    )


def drawn_machine(random: np.random.Generator, off: float = 0.05) -> Machine:
    """A machine of that make, on whose bench the gearbox is stiff."""
    return replace(
        near(stock_machine(), random, off),
        gear_frequency=random.uniform(350.0, 800.0),
        gear_damping=random.uniform(0.1, 0.3),
        bristle_travel=random.uniform(3e-4, 9e-4),
        cycle=int(random.choice([4, 8, 16])),
    )


def near(machine: Machine, random: np.random.Generator, off: float) -> Machine:
    """A machine whose constants are each off by up to ``off``.

    The torque constant by a fifth of that: all torques and inertias off by one factor are the same as a torque
    constant off by it, and no recording could tell.
    """
    shares = {name: off for name in DRAWN} | {"torque_constant": 0.2 * off}
    drawn = {name: getattr(machine, name) * (1.0 + random.uniform(-share, share)) for name, share in shares.items()}
    return replace(machine, **drawn)


def described(model: Model, machine: Machine) -> Model:
    """The stock model with the constants of another machine."""
    stock = stock_machine()
    ratio = machine.gear_ratio / model.value("machine.gear_ratio") if machine.gear_ratio else 1.0
    gearbox = model.value("machine.gearbox_inertia")
    for path, value in (
        ("machine.motor_inertia", machine.motor_inertia - gearbox),
        ("machine.output_inertia", machine.output_inertia),
        ("machine.torque_constant", machine.torque_constant),
        ("machine.gear_ratio", model.value("machine.gear_ratio") * ratio),
        ("drive.position_gain", model.value("drive.position_gain") * ratio),
        ("drive.speed_gain", model.value("drive.speed_gain") * machine.speed_gain),
    ):
        model = model.with_value(path, value)
    for name, factor in (
        ("viscous_friction", machine.motor_viscous / stock.motor_viscous),
        ("viscous_friction_2", machine.output_viscous / stock.output_viscous),
        ("coulomb_friction", machine.motor_level / stock.motor_level),
        ("coulomb_friction_2", machine.output_level / stock.output_level),
    ):
        instance = model.effects[name]
        size = next(iter(instance.parameters))
        model = model.with_value(f"effects.{name}.{size}", instance.parameters[size] * factor)
    return model

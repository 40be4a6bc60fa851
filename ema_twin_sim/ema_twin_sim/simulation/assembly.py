"""From a model to what the kernel takes: one record of constants and the arrays of effects."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from ..effects import Effect, catalogue
from ..model import EffectInstance, Model
from ..plant.layout import DRY_LEVEL, PLANT
from ..plant.operating_point import PARAMETER_SLOTS, compile_effect

_SAME_NAME = (
    "machine.gear_ratio",
    "machine.output_inertia",
    "machine.torque_constant",
    "machine.back_emf_constant",
    "machine.phase_resistance",
    "machine.phase_inductance",
    "drive.position_gain",
    "drive.speed_limit",
    "drive.speed_setpoint_filter",
    "drive.speed_gain",
    "drive.integral_time",
    "drive.integral_limit",
    "drive.integral_dead_band",
    "drive.anti_windup_time",
    "drive.torque_limit",
    "drive.current_limit",
    "drive.control_cycle",
    "drive.current_lag",
    "transmission.contact_stiffness",
    "transmission.contact_damping",
    "sensors.speed_smoothing",
)


@dataclass(frozen=True)
class Assembly:
    """The arguments that a model gives to ``plant.kernel.advance``.

    ``plant`` is a record array (1,) of ``layout.PLANT``; ``effects`` holds addresses (n,), places (n,) and
    parameters (n, 4), dry levels first, so that what depends on the level sees it whole.
    """

    plant: np.ndarray
    effects: tuple[np.ndarray, np.ndarray, np.ndarray]


def assemble(model: Model) -> Assembly:
    """Build the kernel's arguments; effects compile on first use (milliseconds) and are cached on disk."""
    plant = np.zeros(1, PLANT)
    record = plant[0]
    for path in _SAME_NAME:
        record[path.partition(".")[2]] = model.value(path)
    record["motor_inertia"] = model.value("machine.motor_inertia") + model.value("machine.gearbox_inertia")
    record["nominal_torque_constant"] = model.value("machine.torque_constant")
    record["two_inertia"] = model.kinds["transmission"] == "two_inertia"
    record["motor_counts"] = model.value("sensors.motor_encoder_counts")
    record["output_counts"] = model.value("sensors.output_encoder_counts")
    for side, none in (("lower", -np.inf), ("upper", np.inf)):
        stop = model.constants.get(f"transmission.end_stop_{side}")
        record[f"end_stop_{side}"] = none if stop is None else stop.value
    acting = []
    for instance in model.effects.values():
        if not instance.enabled:
            continue
        effect = catalogue()[instance.effect]
        if effect.settle is not None:
            effect.settle(record, instance.parameters, instance.options)
        else:
            acting.append((effect.where(instance.options), _address(effect), _slots(effect, instance)))
    acting.sort(key=lambda entry: entry[0] != DRY_LEVEL)
    return Assembly(
        plant,
        (
            np.array([address for _, address, _ in acting], np.int64),
            np.array([place for place, _, _ in acting], np.int64),
            np.array([slots for _, _, slots in acting], np.float64).reshape(len(acting), PARAMETER_SLOTS),
        ),
    )


def _slots(effect: Effect, instance: EffectInstance) -> list[float]:
    values = [instance.parameters[parameter.name] for parameter in effect.parameters]
    if effect.option_value is not None:
        values.append(effect.option_value(instance.options))
    return values + [0.0] * (PARAMETER_SLOTS - len(values))


@cache
def _address(effect: Effect) -> int:
    assert effect.act is not None  # only effects that act have an address
    return compile_effect(effect.act, cache=True)

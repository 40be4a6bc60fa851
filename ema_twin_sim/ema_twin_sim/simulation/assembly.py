"""Turn a model into the kernel's arguments: one record of constants and the arrays of effects."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np

from ema_bench_replay.errors import InputError

from ..effects import Effect, Trait, catalogue, mesh_friction, the_effect
from ..effects.catalogue import is_own
from ..model import EffectInstance, Model
from ..model.own_units import shown
from ..plant.layout import ANGLE_ERRORS, DRY_LEVEL, ENCODER_MEMORY, PLANT, Effects
from ..plant.operating_point import PARAMETER_SLOTS, compile_effect
from .fidelity import FineParts, fine_parts
from .lumped_train import lump_train
from .unknown_controller import control_cycle

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
    "drive.current_lag",
    "transmission.contact_stiffness",
    "transmission.contact_damping",
    "sensors.speed_smoothing",
)


@dataclass(frozen=True)
class Assembly:
    """A model's arguments for a ``plant.kernel``, and for code that balances torques without integration.

    For a planetary train, ``plant`` and ``effects`` describe the two inertias that replace it (``lumped_train.py``);
    for a switching drive the averaged one, with winding faults as torques. ``plant`` is a record array (1,) of
    ``layout.PLANT``; ``effects`` holds addresses (n,), places (n,) and parameters (n, 4), dry levels first, and the
    factors on them last of these, so that what depends on the level sees it whole. (The loss of a train is not scaled:
    its simulated teeth are not either.)
    """

    plant: np.ndarray
    effects: Effects
    acting: Effects  # without the effects that replace a train's own losses and the faults of a simulated winding
    fine: FineParts


def assemble(model: Model, *, by_current: bool = False) -> Assembly:
    """Build the kernel's arguments. Effects compile on first use (milliseconds); the package's are cached on disk.

    ``by_current``: a measured current drives the mechanics, so that the winding of a switching drive is not simulated.
    Raises InputError if the model's parts do not fit together.
    """
    plant = np.zeros(1, PLANT)
    record = plant[0]
    for path in _SAME_NAME:
        record[path.partition(".")[2]] = model.value(path)
    record["control_cycle"] = control_cycle(model)
    record["motor_inertia"] = model.value("machine.motor_inertia") + model.value("machine.gearbox_inertia")
    record["nominal_torque_constant"] = model.value("machine.torque_constant")
    record["two_inertia"] = model.kinds["transmission"] == "two_inertia"
    turn = 2.0 * math.pi / model.turn  # the plant's counts refer to a revolution
    record["motor_counts"] = turn * model.value("sensors.motor_encoder_counts")
    noise = model.value("sensors.motor_encoder_noise")  # standard deviation in counts, of which three are seen
    record["motor_dither"] = math.hypot(1.0, 3.0 * noise) * 2.0 * math.pi / record["motor_counts"]
    record["output_counts"] = turn * model.value("sensors.output_encoder_counts")
    for side, none in (("lower", -np.inf), ("upper", np.inf)):
        stop = model.constants.get(f"transmission.end_stop_{side}")
        record[f"end_stop_{side}"] = none if stop is None else stop.value
    record["pole_pairs"] = math.nan if model.pole_pairs is None else model.pole_pairs
    by_winding = model.kinds["drive"] == "switching" and not by_current
    balanced, acting = [], []
    for name, instance in _factors_last(model.active):
        effect = catalogue()[instance.effect]
        if effect.electrical and model.pole_pairs is None:
            raise InputError(f"model {model.name}: effect {name} needs machine.pole_pairs; give it in the model file")
        if effect.settle is not None:
            effect.settle(record, instance.parameters, instance.options)
        if effect.act is not None:
            entry = (effect.where(instance.options), effect_address(effect), effect_slots(effect, instance))
            balanced.append(entry)
            if not (by_winding and effect.settle_winding is not None):
                acting.append(entry)
    fine = fine_parts(model, record)
    if fine.planetary:
        loss = lump_train(model, record, fine)
        balanced.append((mesh_friction.EFFECT.where({}), effect_address(mesh_friction.EFFECT), [loss, 0.0, 0.0, 0.0]))
    _check(model, record)
    return Assembly(plant, _effects(balanced), _effects(acting), fine)


def _factors_last(active: Mapping[str, EffectInstance]) -> list[tuple[str, EffectInstance]]:
    """The active effects by name, those that scale the whole level of dry friction last."""
    return sorted(active.items(), key=lambda named: Trait.SCALES_DRY_FRICTION in catalogue()[named[1].effect].traits)


def _effects(acting: list[tuple[int, int, list[float]]]) -> Effects:
    """Acting effects (target, address, parameters) as arrays, dry levels first."""
    ordered = sorted(acting, key=lambda entry: entry[0] != DRY_LEVEL)
    return (
        np.array([address for _, address, _ in ordered], np.int64),
        np.array([place for place, _, _ in ordered], np.int64),
        np.array([slots for _, _, slots in ordered], np.float64).reshape(len(ordered), PARAMETER_SLOTS),
    )


def _check(model: Model, record: np.void) -> None:
    """Refuse invalid plants, after all effects were applied."""
    if record["two_inertia"] and not record["output_inertia"] > 0.0:
        raise InputError(
            f"model {model.name}: machine.output_inertia is 0, and a transmission with play or a spring needs it; "
            "write what of the inertia is behind the gearbox as machine.output_inertia, and the rest as inertia"
        )
    if record["angle_errors"] > ANGLE_ERRORS:
        raise InputError(
            f"model {model.name}: has {record['angle_errors']} {the_effect(Trait.SENSOR_WAVE)}; "
            f"give {ANGLE_ERRORS} at most"
        )
    longest = longest_delay(model)
    if record["encoder_delay"] > longest:
        late, most = (shown(model, float(time), "s")[0] for time in (record["encoder_delay"], longest))
        raise InputError(
            f"model {model.name}: the encoder's delay of {late:g} s is more than {most:.4g} s, "
            f"what {ENCODER_MEMORY} control cycles hold; give a shorter delay or a longer drive.control_cycle"
        )


def longest_delay(model: Model) -> float:
    """The longest encoder delay [s] that the plant can simulate: the length of its memory of control cycles."""
    return (ENCODER_MEMORY - 2) * control_cycle(model)


def effect_slots(effect: Effect, instance: EffectInstance) -> list[float]:
    """The four numbers passed to a compiled effect: its parameters, then a numeric option, then zeros."""
    values = [instance.parameters.get(parameter.name, parameter.default) for parameter in effect.parameters]
    if effect.option_value is not None:
        values.append(effect.option_value(instance.options))
    return values + [0.0] * (PARAMETER_SLOTS - len(values))


@cache
def effect_address(effect: Effect) -> int:
    """Memory address of the compiled function of an effect with ``act``."""
    assert effect.act is not None  # only effects with ``act`` have an address
    return compile_effect(effect.act, on_disk=not is_own(effect))

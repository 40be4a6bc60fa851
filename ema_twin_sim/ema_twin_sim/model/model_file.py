"""Model files: YAML, ``{version, machine, drive, transmission, sensors, effects}``, read strictly, written complete.

A file may name a ``base`` in the same folder (models of one bench share one file of constants); its own entries
override those of the base. A written file is always complete and needs no base. If less is known of a machine, the file
may give one ``inertia`` (for a linear machine: its mass) instead of those of motor, gearbox and output, and leave out
what the machine does not have. ``tolerance: open`` marks a value that is only the start of a fit. ``orders`` names what
repeats with the motor's turns, in cycles per turn (``pole pairs``: the electrical angle), or along a linear machine's
way, in cycles per metre; ``other_orders: false`` says that nothing else does, so that no other order is searched.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import yaml

from ema_bench_replay.checked_yaml import Checker, parse_yaml, read_yaml
from ema_bench_replay.configuration import find_configuration
from ema_bench_replay.errors import InputError
from ema_bench_replay.outputs import write_text
from ema_bench_replay.units import MOTIONS, unit_in, usual_spelling

from ..effects import find_effect
from .check_comment import REMEDIES, check_comment, is_assumed
from .constants import CHOICES, CONSTANTS, KINDS, PARTS, Constant
from .model import LUMPED, ConstantValue, EffectInstance, Model, check_range, checked_instance

VERSION = 1
OPEN = "open"
ABSENT = "not given: the machine has none"
TORQUE_CONSTANT = "machine.torque_constant"
SHAFTS = ("motor", "output")
"""Shafts to which a torque constant may refer; a model holds the one at the motor."""
_KEYS = ("version", "base", *PARTS, "orders", "other_orders", "effects")


def load_model(name: str | os.PathLike[str]) -> Model:
    """Load a model from a file, or by name from config/models. Raises InputError with file, place and remedy."""
    content, files = _read_whole(name)
    return _model(files[0], content)


def model_files(name: str | os.PathLike[str]) -> list[Path]:
    """The files of a model: its own and its bases."""
    return _read_whole(name)[1]


def save_model(model: Model, path: str | os.PathLike[str], *, force: bool = False) -> Path:
    """Write a complete model file that loads as the same model.

    Raises InputError if the file exists (without ``force``) or cannot be written.
    """
    path = Path(path)
    check_model_name(path)
    text = _text(model)
    try:
        _model(path, parse_yaml(text))
    except InputError as error:  # a programming error: the given model is invalid
        raise RuntimeError(f"a model is not written that would not load again: {error}") from error
    head = "# EMA twin model, whole; units as stated, tolerances relative (one std)\n"
    write_text(path, f"{head}{_units_of_effects(model)}{text}", force=force)
    return path


def _text(model: Model) -> str:
    """A complete model as YAML."""
    content: dict[str, object] = {"version": VERSION, "machine": {"name": model.machine}}
    if model.motion != "rotary":
        content["machine"] = {"name": model.machine, "motion": model.motion}
    for part in PARTS[1:]:
        content[part] = {"kind": model.kinds[part]} if part in model.kinds else {}
    for chosen_path, chosen in model.choices.items():
        part, _, word = chosen_path.partition(".")
        content[part][word] = chosen  # type: ignore[index]
    for constant_path, held in model.constants.items():
        constant = CONSTANTS[constant_path]
        if held.source == ABSENT:
            continue
        tolerance = OPEN if math.isinf(held.tolerance) else held.tolerance
        entry: dict[str, object] = {"value": float(held.value), "unit": model.unit(constant_path)}
        entry["tolerance"] = tolerance
        if held.source:
            entry["source"] = held.source
        content[constant.part][model.shown_path(constant_path).partition(".")[2]] = entry  # type: ignore[index]
    if model.orders:
        content["orders"] = dict(model.orders)
    if not model.other_orders:
        content["other_orders"] = False
    content["effects"] = {
        name: {
            "effect": instance.effect,
            "options": dict(instance.options),
            "parameters": {parameter: float(value) for parameter, value in instance.parameters.items()},
            **({} if instance.enabled else {"enabled": False}),
            **({"open": True} if instance.open else {}),
        }
        for name, instance in model.effects.items()
    }
    return _with_marks(model, yaml.dump(content, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=160))


def _with_marks(model: Model, text: str) -> str:
    """The YAML of a model with the mark of a draft at the end of constants that are still only assumed."""
    for path, remedy in REMEDIES.items():
        held = model.constants.get(path)
        if held is not None and is_assumed(held.source):
            entry = rf"^  {path.partition('.')[2]}: {{[^}}]*}}$"
            text = re.sub(entry, rf"\g<0>{check_comment(remedy)}", text, count=1, flags=re.MULTILINE)
    return text


def _units_of_effects(model: Model) -> str:
    """A comment line for each effect of a model."""
    lines = []
    for effect in dict.fromkeys(instance.effect for instance in model.effects.values()):
        names = [parameter.name for parameter in find_effect(effect, "effect").parameters]
        units = ", ".join(f"{name} [{model.parameter_unit(effect, name)}]" for name in names)
        lines.append(f"# {effect}: {units or 'no parameters'}\n")
    return "".join(lines)


def check_model_name(path: Path) -> None:
    """Raise InputError if a file with that name would not be recognised as a model."""
    if path.suffix not in (".yaml", ".yml"):
        raise InputError(
            f"{path}: a model file is named .yaml (without it, it would hide a shipped model of that name)"
        )


class _Dumper(yaml.SafeDumper):
    """Innermost mappings on one line each, as in the shipped files."""

    def represent_mapping(self, tag: str, mapping: Any, flow_style: bool | None = None) -> yaml.MappingNode:
        leaf = all(not isinstance(value, Mapping) or not value for value in mapping.values())
        return super().represent_mapping(tag, mapping, flow_style=leaf)


def _read_whole(name: str | os.PathLike[str]) -> tuple[dict[str, object], list[Path]]:
    """The content of a model file merged over its bases, and the list of files."""
    path = Path(name)
    if path.suffix not in (".yaml", ".yml") and not path.is_file():
        path = find_configuration("models", path if path.is_dir() else f"{name}.yaml")
    content = _read(path)
    files = [path]
    while "base" in content:
        below = _base(files[-1], content.pop("base"))
        content = _merged(_read(below), content)
        if below.resolve() in [file.resolve() for file in files]:
            raise InputError(f"{path}: base: '{below.name}' leads back to itself; name a file of constants")
        files.append(below)
    return content, files


def _base(path: Path, named: object) -> Path:
    """The file named by a model's ``base``: in the same folder, or a shipped one by name."""
    name = Checker(path).text(named, "base")
    beside = path.parent / name
    try:
        return beside if beside.is_file() else find_configuration("models", name)
    except (InputError, OSError, ValueError):  # OSError, ValueError: an invalid file name
        raise InputError(
            f"{path}: base: {name[:200]!r} is no file beside it, and no model in config/models; name one of them"
        ) from None


def _read(path: Path) -> dict[str, object]:
    content, _ = read_yaml(path, "give a model file, or a name in config/models")
    return dict(Checker(path).mapping(content, "", _KEYS))


def _merged(below: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    result = dict(below)
    for key, value in above.items():
        both = isinstance(value, Mapping) and isinstance(result.get(key), Mapping)
        result[key] = _merged(result[key], value) if both and key != "effects" else value
    return result


def _model(path: Path, content: Mapping[str, Any]) -> Model:
    check = Checker(path)
    check.choice(content.get("version"), "version", (VERSION,))
    machine = check.mapping(content.get("machine"), "machine")
    motion = check.choice(machine.get("motion", MOTIONS[0]), "machine.motion", MOTIONS)
    lumped = LUMPED in machine
    kinds = {
        part: check.choice(check.mapping(content.get(part, {}), part).get("kind", among[0]), f"{part}.kind", among)
        for part, among in KINDS.items()
    }
    choices: dict[str, str] = {}
    constants: dict[str, ConstantValue] = {}
    for part in PARTS:
        names = {c.name: c for c in CONSTANTS.values() if c.part == part}
        words = {p.partition(".")[2] for of in CHOICES.values() for p in of if p.startswith(f"{part}.")}
        words |= {"name", "motion", LUMPED} if part == "machine" else ({"kind"} if part in KINDS else set())
        section = _section(check, content.get(part, {}), part, (*sorted(words), *names))
        for place, among in ((p, a) for kind in kinds.values() for p, a in CHOICES.get(kind, {}).items()):
            if place.startswith(f"{part}."):
                choices[place] = check.choice(section.get(place.partition(".")[2], among[0]), place, among)
        for name, constant in names.items():
            given = LUMPED if lumped and name == "motor_inertia" else name
            foreign = constant.kind and constant.kind not in kinds.values()
            if foreign and not (constant.everywhere and section.get(given) is not None):
                continue  # models of one bench share a file of constants, whatever their fidelity
            if lumped and name in section and name in ("motor_inertia", "gearbox_inertia"):
                raise check.error(f"machine.{name}", "stands beside the machine's one inertia", "give one or the other")
            if section.get(given) is not None:
                constants[constant.path] = _constant(check, constant, section[given], f"{part}.{given}", motion)
            elif lumped and constant.absent is not None:
                constants[constant.path] = ConstantValue(constant.absent, 0.0, ABSENT)
            elif constant.usual is not None:
                constants[constant.path] = ConstantValue(constant.usual, 0.0, ABSENT)
            elif not constant.optional:
                unit = unit_in(constant.unit, motion)
                how = "give its value, a plain number" if unit == "1" else f"give its value in {unit}"
                raise check.error(f"{part}.{name}", "is missing", how)
    if TORQUE_CONSTANT in constants and isinstance(of_motor := machine.get("torque_constant"), dict):
        shaft = check.choice(of_motor.get("shaft", SHAFTS[0]), f"{TORQUE_CONSTANT}.shaft", SHAFTS)
        if shaft != SHAFTS[0]:  # a joint's torque per ampere includes the gear ratio
            held = constants[TORQUE_CONSTANT]
            constants[TORQUE_CONSTANT] = held.at(held.value / constants["machine.gear_ratio"].value)
    name = check.text(machine.get("name", path.stem), "machine.name")
    effects = content.get("effects")
    parts = {} if effects is None else _effects(check, effects, motion)
    orders = check.mapping(content.get("orders", {}), "orders")
    named = {str(k): check.number(v, f"orders.{k}", lower=1e-6, upper=1e6) for k, v in orders.items()}
    others = check.boolean(content.get("other_orders", True), "other_orders")
    return Model(
        path.stem, name, kinds, constants, parts, motion, lumped, orders=named, other_orders=others, choices=choices
    )


def _section(check: Checker, content: object, part: str, allowed: Sequence[str]) -> Mapping[str, Any]:
    """A part of the file with the ``allowed`` keys only; of a key that belongs elsewhere the refusal says where."""
    for key in content if isinstance(content, dict) else ():
        if key in allowed:
            continue
        if key in _KEYS:
            raise check.error(part, f"unknown key {key!r}", f"move it to the top level of the file, beside `{part}:`")
        if owner := next((c.part for c in CONSTANTS.values() if c.name == key), None):
            raise check.error(part, f"unknown key {key!r}", f"move it under `{owner}:`")
    return check.mapping(content, part, allowed)


def _constant(check: Checker, constant: Constant, content: object, place: str, motion: str) -> ConstantValue:
    unit = unit_in(constant.unit, motion)
    shaft = ("shaft",) if constant.path == TORQUE_CONSTANT else ()
    entry = check.mapping(content, place, ("value", "unit", "tolerance", "source", *shaft), required=("value", "unit"))
    if usual_spelling(str(entry["unit"])) != unit:
        raise check.error(place, f"unit '{entry['unit']}' but '{unit}' is needed", "convert the value")
    place = f"{check.path}: {place}"
    value = check_range(entry["value"], constant.lower, constant.upper, unit, place)
    tolerance = entry.get("tolerance", 0.05)
    if tolerance == OPEN:
        return ConstantValue(value, math.inf, str(entry.get("source", "")))
    return ConstantValue(
        value, check_range(tolerance, 0.0, 10.0, "(relative)", f"{place}.tolerance"), str(entry.get("source", ""))
    )


def _effects(check: Checker, content: object, motion: str) -> dict[str, EffectInstance]:
    effects = {}
    for name, value in check.mapping(content, "effects").items():
        place = f"effects.{name}"
        entry = check.mapping(value, place, ("effect", "options", "parameters", "enabled", "open"))
        effect = find_effect(str(entry.get("effect", name)), f"{check.path}: {place}")
        later = "(_([2-9]|[1-9][0-9]+))?" if effect.repeatable else ""
        if not re.fullmatch(effect.id + later, str(name)):
            names = f"is named {effect.id}, {effect.id}_2, …" if effect.repeatable else f"is there once, as {effect.id}"
            raise check.error(place, f"an instance of {effect.id} {names}", "rename or remove this one")
        given = {key: entry.get(key) for key in ("parameters", "options")}
        parameters, options = ({} if v is None else check.mapping(v, f"{place}.{k}") for k, v in given.items())
        instance = checked_instance(effect, parameters, options, f"{check.path}: {place}", complete=True, motion=motion)
        enabled, is_open = (
            check.boolean(entry.get(key, usual), f"{place}.{key}")
            for key, usual in (("enabled", True), ("open", False))
        )
        effects[str(name)] = replace(instance, enabled=enabled, open=is_open)
    return effects

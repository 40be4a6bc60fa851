"""Model files: YAML, ``{version, machine, drive, transmission, sensors, effects}``, read strictly and written whole.

A file may name a ``base`` beside it (models of one bench share one file of constants); its own entries then overrule
the base's. What is written is always whole: a file that stands alone.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import yaml

from ema_bench_replay.checked_yaml import Checker, read_yaml
from ema_bench_replay.configuration import find_configuration
from ema_bench_replay.errors import InputError
from ema_bench_replay.outputs import new_file

from ..effects import find_effect
from .constants import CONSTANTS, KINDS, PARTS, Constant
from .model import ConstantValue, EffectInstance, Model, check_range, checked_instance

VERSION = 1
_KEYS = ("version", "base", *PARTS, "effects")


def load_model(name: str | os.PathLike[str]) -> Model:
    """The model in a file, or the one of that name in config/models. Raises InputError with file, place and remedy."""
    content, files = _read_whole(name)
    return _model(files[0], content)


def model_files(name: str | os.PathLike[str]) -> list[Path]:
    """The files that a model is read from: its own and those that it is based on."""
    return _read_whole(name)[1]


def save_model(model: Model, path: str | os.PathLike[str], *, force: bool = False) -> Path:
    """Write a model whole. Raises InputError where the file exists (without ``force``) or cannot be written."""
    path = Path(path)
    check_model_name(path)
    content: dict[str, object] = {"version": VERSION, "machine": {"name": model.machine}}
    for part in PARTS[1:]:
        content[part] = {"kind": model.kinds[part]} if part in model.kinds else {}
    for constant_path, held in model.constants.items():
        constant = CONSTANTS[constant_path]
        entry: dict[str, object] = {"value": float(held.value), "unit": constant.unit, "tolerance": held.tolerance}
        if held.source:
            entry["source"] = held.source
        content[constant.part][constant.name] = entry  # type: ignore[index]
    content["effects"] = {
        name: {
            "effect": instance.effect,
            "options": dict(instance.options),
            "parameters": {parameter: float(value) for parameter, value in instance.parameters.items()},
            **({} if instance.enabled else {"enabled": False}),
        }
        for name, instance in model.effects.items()
    }
    text = yaml.dump(content, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=160)
    with new_file(path, force=force) as file:
        file.write(f"# EMA twin model, whole; units as stated, tolerances relative (one std)\n{text}".encode())
    return path


def check_model_name(path: Path) -> None:
    """Raise InputError where a file of that name would not be taken for a model."""
    if path.suffix not in (".yaml", ".yml"):
        raise InputError(
            f"{path}: a model file is named .yaml (without it, it would hide a shipped model of that name)"
        )


class _Dumper(yaml.SafeDumper):
    """Innermost mappings on one line each, as in the shipped files."""

    def represent_mapping(self, tag, mapping, flow_style=None):
        leaf = all(not isinstance(value, Mapping) or not value for value in mapping.values())
        return super().represent_mapping(tag, mapping, flow_style=leaf)


def _read_whole(name: str | os.PathLike[str]) -> tuple[dict[str, object], list[Path]]:
    """The content of a model's file over that of its bases, and these files."""
    path = Path(name)
    if path.suffix not in (".yaml", ".yml") and not path.is_file():
        path = find_configuration("models", f"{name}.yaml")
    content = _read(path)
    files = [path]
    while "base" in content:
        below = files[-1].parent / Checker(files[-1]).text(content.pop("base"), "base")
        content = _merged(_read(below), content)
        if below.resolve() in [file.resolve() for file in files]:
            raise InputError(f"{path}: base: '{below.name}' leads back to itself; name a file of constants")
        files.append(below)
    return content, files


def _read(path: Path) -> dict[str, object]:
    content, _ = read_yaml(path, "give a model file, or a name in config/models")
    return dict(Checker(path).mapping(content, "", _KEYS))


def _merged(below: Mapping, above: Mapping) -> dict:
    result = dict(below)
    for key, value in above.items():
        both = isinstance(value, Mapping) and isinstance(result.get(key), Mapping)
        result[key] = _merged(result[key], value) if both and key != "effects" else value
    return result


def _model(path: Path, content: Mapping) -> Model:
    check = Checker(path)
    check.choice(content.get("version"), "version", (VERSION,))
    kinds: dict[str, str] = {}
    constants: dict[str, ConstantValue] = {}
    for part in PARTS:
        names = {c.name: c for c in CONSTANTS.values() if c.part == part}
        words = ("name",) if part == "machine" else (("kind",) if part in KINDS else ())
        section = check.mapping(content.get(part), part, (*words, *names))
        if part in KINDS:
            kinds[part] = check.choice(section.get("kind", KINDS[part][0]), f"{part}.kind", KINDS[part])
        for name, constant in names.items():
            if section.get(name) is None:
                if constant.optional:
                    continue
                raise check.error(f"{part}.{name}", "is missing", f"give its value in {constant.unit}")
            constants[constant.path] = _constant(check, constant, section[name])
    name = check.text(content["machine"].get("name", path.stem), "machine.name")
    effects = content.get("effects")
    return Model(path.stem, name, kinds, constants, {} if effects is None else _effects(check, effects))


def _constant(check: Checker, constant: Constant, content: object) -> ConstantValue:
    place = constant.path
    entry = check.mapping(content, place, ("value", "unit", "tolerance", "source"), required=("value", "unit"))
    if str(entry["unit"]) != constant.unit:
        raise check.error(place, f"unit '{entry['unit']}' but '{constant.unit}' is needed", "convert the value")
    place = f"{check.path}: {place}"
    value = check_range(entry["value"], constant.lower, constant.upper, constant.unit, place)
    tolerance = check_range(entry.get("tolerance", 0.05), 0.0, 10.0, "(relative)", f"{place}.tolerance")
    return ConstantValue(value, tolerance, str(entry.get("source", "")))


def _effects(check: Checker, content: object) -> dict[str, EffectInstance]:
    effects = {}
    for name, value in check.mapping(content, "effects").items():
        place = f"effects.{name}"
        entry = check.mapping(value, place, ("effect", "options", "parameters", "enabled"))
        effect = find_effect(str(entry.get("effect", name)), f"{check.path}: {place}")
        later = "(_([2-9]|[1-9][0-9]+))?" if effect.repeatable else ""
        if not re.fullmatch(effect.id + later, str(name)):
            names = f"is named {effect.id}, {effect.id}_2, …" if effect.repeatable else f"is there once, as {effect.id}"
            raise check.error(place, f"an instance of {effect.id} {names}", "rename or remove this one")
        given = {key: entry.get(key) for key in ("parameters", "options")}
        parameters, options = ({} if v is None else check.mapping(v, f"{place}.{k}") for k, v in given.items())
        instance = checked_instance(effect, parameters, options, f"{check.path}: {place}", complete=True)
        effects[str(name)] = replace(instance, enabled=check.boolean(entry.get("enabled", True), f"{place}.enabled"))
    return effects

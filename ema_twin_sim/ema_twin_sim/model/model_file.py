"""Model files: YAML, ``{version, machine, drive, transmission, sensors, effects}``, read strictly and written whole.

A file may name a ``base`` beside it (models of one bench share one file of constants); its own entries then overrule
the base's. What is written is always whole: a file that stands alone.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

import yaml

from ema_bench_replay.configuration import find_configuration
from ema_bench_replay.errors import InputError
from ema_bench_replay.outputs import new_file

from ..effects import find_effect
from .constants import CONSTANTS, KINDS, PARTS
from .model import ConstantValue, EffectInstance, Model, check_range, checked_instance, nearest

VERSION = 1
_KEYS = ("version", "base", *PARTS, "effects")
_LARGEST = 1 << 20  # bytes; a model file is a few kilobytes


def load_model(name: str | os.PathLike[str]) -> Model:
    """The model in a file, or the one of that name in config/models. Raises InputError with file, place and remedy."""
    path = Path(name)
    if path.suffix not in (".yaml", ".yml") and not path.is_file():
        path = find_configuration("models", f"{name}.yaml")
    content = _read(path)
    seen = {path.resolve()}
    while "base" in content:
        below = path.parent / str(content.pop("base"))
        if below.resolve() in seen:
            raise InputError(f"{path}: base: '{below.name}' leads back to itself; name a file of constants")
        seen.add(below.resolve())
        content = _merged(_read(below), content)
    return _model(path, content)


def save_model(model: Model, path: str | os.PathLike[str], *, force: bool = False) -> Path:
    """Write a model whole. Raises InputError where the file exists (without ``force``) or cannot be written."""
    path = Path(path)
    if path.suffix not in (".yaml", ".yml"):
        raise InputError(
            f"{path}: a model file is named .yaml (without it, it would hide a shipped model of that name)"
        )
    content: dict[str, object] = {"version": VERSION, "machine": {"name": model.machine}}
    for part in PARTS[1:]:
        content[part] = {"kind": model.kinds[part]} if part in model.kinds else {}
    for constant_path, held in model.constants.items():
        constant = CONSTANTS[constant_path]
        entry: dict[str, object] = {"value": held.value, "unit": constant.unit, "tolerance": held.tolerance}
        if held.source:
            entry["source"] = held.source
        content[constant.part][constant.name] = entry  # type: ignore[index]
    content["effects"] = {
        name: {
            "effect": instance.effect,
            "options": dict(instance.options),
            "parameters": dict(instance.parameters),
            **({} if instance.enabled else {"enabled": False}),
        }
        for name, instance in model.effects.items()
    }
    text = yaml.dump(content, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=160)
    with new_file(path, force=force) as file:
        file.write(f"# EMA twin model, whole; units as stated, tolerances relative (one std)\n{text}".encode())
    return path


class _Dumper(yaml.SafeDumper):
    """Innermost mappings on one line each, as in the shipped files."""

    def represent_mapping(self, tag, mapping, flow_style=None):
        leaf = all(not isinstance(value, Mapping) or not value for value in mapping.values())
        return super().represent_mapping(tag, mapping, flow_style=leaf)


def _read(path: Path) -> dict[str, object]:
    try:
        if path.stat().st_size > _LARGEST:
            raise InputError(f"{path}: larger than 1 MiB; this is no model file")
        content = yaml.safe_load(path.read_text("utf-8"))
    except FileNotFoundError:
        raise InputError(f"{path}: no such model file; give a file or a name in config/models") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); check the file") from None
    except UnicodeDecodeError:
        raise InputError(f"{path}: is not UTF-8 text; a model is a YAML file") from None
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        line = f":{mark.line + 1}" if mark else ""
        raise InputError(f"{path}{line}: not valid YAML ({getattr(error, 'problem', error)}); mend the line") from None
    if not isinstance(content, dict):
        raise InputError(f"{path}: holds no model; a model file has the keys {', '.join(_KEYS)}")
    for key in content:
        if key not in _KEYS:
            raise InputError(f"{path}: unknown key '{key}'; {nearest(str(key), _KEYS)}")
    return content


def _merged(below: Mapping, above: Mapping) -> dict:
    result = dict(below)
    for key, value in above.items():
        both = isinstance(value, Mapping) and isinstance(result.get(key), Mapping)
        result[key] = _merged(result[key], value) if both and key != "effects" else value
    return result


def _section(path: Path, content: Mapping, key: str) -> Mapping:
    section = content.get(key)
    if not isinstance(section, Mapping):
        raise InputError(
            f"{path}: {key}: missing or no mapping; give this section (see config/models/polito_bench.yaml)"
        )
    return section


def _model(path: Path, content: Mapping) -> Model:
    if content.get("version") != VERSION:
        raise InputError(f"{path}: version: {content.get('version')!r} is not known; this program reads {VERSION}")
    kinds: dict[str, str] = {}
    constants: dict[str, ConstantValue] = {}
    for part in PARTS:
        section = _section(path, content, part)
        names = {c.name: c for c in CONSTANTS.values() if c.part == part}
        words = ("name",) if part == "machine" else (("kind",) if part in KINDS else ())
        for name in section:
            if name not in names and name not in words:
                raise InputError(f"{path}: {part}: unknown key '{name}'; {nearest(str(name), (*names, *words))}")
        if part in KINDS:
            kind = section.get("kind", KINDS[part][0])
            if kind not in KINDS[part]:
                raise InputError(f"{path}: {part}.kind: '{kind}' is not known; give one of {', '.join(KINDS[part])}")
            kinds[part] = kind
        for name, constant in names.items():
            if section.get(name) is None:
                if constant.optional:
                    continue
                raise InputError(f"{path}: {part}.{name} is missing; give its value in {constant.unit}")
            constants[constant.path] = _constant(path, constant.path, section[name])
    name = content["machine"].get("name", path.stem)
    return Model(path.stem, str(name), kinds, constants, _effects(path, content.get("effects")))


def _constant(path: Path, place: str, entry: object) -> ConstantValue:
    constant = CONSTANTS[place]
    if not isinstance(entry, Mapping) or "value" not in entry:
        raise InputError(f"{path}: {place}: give {{value: …, unit: {constant.unit}}}")
    for key in entry:
        if key not in ("value", "unit", "tolerance", "source"):
            raise InputError(
                f"{path}: {place}: unknown key '{key}'; {nearest(str(key), ('value', 'unit', 'tolerance', 'source'))}"
            )
    if str(entry.get("unit")) != constant.unit:
        raise InputError(
            f"{path}: {place}: unit '{entry.get('unit')}' but '{constant.unit}' is needed; convert the value"
        )
    value = check_range(entry["value"], constant.lower, constant.upper, constant.unit, f"{path}: {place}")
    tolerance = check_range(entry.get("tolerance", 0.05), 0.0, 10.0, "(relative)", f"{path}: {place}.tolerance")
    return ConstantValue(value, tolerance, str(entry.get("source", "")))


def _effects(path: Path, section: object) -> dict[str, EffectInstance]:
    if section is None:
        return {}
    if not isinstance(section, Mapping):
        raise InputError(f"{path}: effects: no mapping; give NAME: {{effect: ID, parameters: {{…}}}}")
    effects = {}
    for name, entry in section.items():
        place = f"{path}: effects.{name}"
        if not isinstance(entry, Mapping):
            raise InputError(f"{place}: give {{effect: ID, parameters: {{…}}}}")
        keys = ("effect", "options", "parameters", "enabled")
        for key in entry:
            if key not in keys:
                raise InputError(f"{place}: unknown key '{key}'; {nearest(str(key), keys)}")
        effect = find_effect(str(entry.get("effect", name)), place)
        if name != effect.id and not str(name).removeprefix(f"{effect.id}_").isdigit():
            raise InputError(f"{place}: an instance of {effect.id} is named {effect.id}, {effect.id}_2, …; rename it")
        instance = checked_instance(
            effect, entry.get("parameters") or {}, entry.get("options") or {}, place, complete=True
        )
        effects[str(name)] = EffectInstance(
            instance.effect, instance.options, instance.parameters, bool(entry.get("enabled", True))
        )
    return effects

"""``ema-twin diff``: the differences between two models."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated

import typer
from rich.markup import escape

from . import options
from .output import console, say
from .tables import ReportTable, with_unit

if TYPE_CHECKING:
    from ..model import Model

EXAMPLES = """Examples:

ema-twin diff polito_bench better.yaml

ema-twin diff polito_hf polito_hff --json difference.json"""

NONE = "–"


def run(
    first: Annotated[str, typer.Argument(metavar="MODEL", help="A model file, or a name in config/models.")],
    second: Annotated[str, typer.Argument(metavar="OTHER", help="The model to compare with it.")],
    with_files: options.WithFiles = None,
    json: options.JsonFile = None,
) -> None:
    """Show what two models differ in: fidelities, constants with their tolerances, effects with their parameters."""
    from ..model import load_model
    from ..model.model_file import model_files
    from ..own_effects import load_effects
    from .inputs import refuse_inputs, write_json

    load_effects(with_files or ())
    models = load_model(first), load_model(second)
    refuse_inputs([*model_files(first), *model_files(second), *(with_files or ())], json)
    names = [model.name for model in models]
    if names[0] == names[1]:
        names = [first, second]
    differences = list(_differences(*models))
    if not differences:
        say(f"{names[0]} and {names[1]} are identical.")
    else:
        table = ReportTable()
        table.words("what", *map(escape, names))
        for what, *values in differences:
            table.add_row(escape(what), *map(escape, values))
        console.print(table)
    rows = [{"what": what, "first": one, "second": other} for what, one, other in differences]
    write_json(json, {"models": list(names), "differences": rows})


def _differences(first: Model, second: Model) -> Iterator[tuple[str, str, str]]:
    for of in (_kinds, _constants, _effects):
        one, other = of(first), of(second)
        for what in dict.fromkeys([*one, *other]):
            values = one.get(what, NONE), other.get(what, NONE)
            if values[0] != values[1]:
                yield what, *values


def _kinds(model: Model) -> dict[str, str]:
    kinds = {f"{part}.kind": kind for part, kind in model.kinds.items()}
    return {"machine": model.machine, "motion": model.motion, **kinds, **model.choices}


def _constants(model: Model) -> dict[str, str]:
    from ..model.model_file import ABSENT, OPEN

    found = {}
    for path, held in model.constants.items():
        if held.source != ABSENT:
            tolerance = OPEN if math.isinf(held.tolerance) else f"± {100.0 * held.tolerance:g} %"
            found[model.shown_path(path)] = f"{with_unit(held.value, model.unit(path))} {tolerance}"
    return found


def _effects(model: Model) -> dict[str, str]:
    found = {}
    for name, instance in model.effects.items():
        words = [f"{option} {choice}" for option, choice in instance.options.items()]
        for parameter, value in instance.parameters.items():
            words.append(f"{parameter} {with_unit(value, model.parameter_unit(instance.effect, parameter))}")
        words += ([] if instance.enabled else ["off"]) + (["open"] if instance.open else [])
        found[name] = ", ".join(words) or "present"
    return found

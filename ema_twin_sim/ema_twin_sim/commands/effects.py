"""``ema-twin effects``: the catalogue."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.markup import escape

from . import options
from .output import console, say
from .tables import ReportTable

if TYPE_CHECKING:
    from ..effects import Effect

EXAMPLES = """Examples:

ema-twin effects

ema-twin effects backlash --json backlash.json

ema-twin effects --with position_friction.py position_friction"""


def run(
    id: Annotated[
        str | None, typer.Argument(metavar="ID", help="Show one effect in full.", autocompletion=options.effect_names)
    ] = None,
    with_files: options.WithFiles = None,
    json: options.JsonFile = None,
) -> None:
    """List the catalogue of physical effects: equation, parameters with units and bounds, signature in the residual."""
    from ..effects import catalogue, find_effect
    from .inputs import refuse_inputs, write_json

    files = {}
    if with_files:  # the compiler takes a while to load, and the catalogue alone does not need it
        from ..own_effects import load_effect

        refuse_inputs(with_files, json)
        files = {load_effect(file).id: file for file in with_files}
    chosen = [find_effect(id, "effects")] if id else list(catalogue().values())
    if id:
        _show_one(chosen[0], files.get(id, id))
    else:
        table = ReportTable()
        table.words("effect", "equation", "parameters", "signature in the residual")
        for effect in chosen:
            parameters = ", ".join(f"{p.name} [{p.unit}]" for p in effect.parameters)
            table.add_row(effect.id, *map(escape, (effect.equation, parameters, effect.signature)))
        console.print(table)
        say("T torque, L dry friction level, b viscous coefficient, ω speed, θ angle: of the motor shaft; θ_o: output.")
        say("One effect in full: ema-twin effects ID. Add one: ema-twin add ID --model MODEL -o NEW.yaml")
    contents = [
        {
            **{name: getattr(effect, name) for name in ("id", "summary", "equation", "signature", "source")},
            "options": {name: list(choices) for name, choices in effect.options.items()},
            "parameters": {
                p.name: {
                    "unit": p.unit,
                    "default": p.default,
                    "lower": p.lower if math.isfinite(p.lower) else None,  # no bound
                    "upper": p.upper if math.isfinite(p.upper) else None,
                    "text": p.description,
                }
                for p in effect.parameters
            },
        }
        for effect in chosen
    ]
    write_json(json, contents[0] if id else contents)


def _show_one(effect: Effect, name: str | Path) -> None:
    """Print one effect in full; ``name`` is the argument that ``add`` takes for it (its id or its file)."""
    from ..effects.catalogue import is_own
    from ..effects.effect import range_words

    say(f"[bold]{effect.id}[/bold]: {escape(effect.summary)}\n", markup=True)
    say(f"  equation   {effect.equation}")
    say(f"  residual   {effect.signature}")
    say(f"  source     {effect.source}\n")
    table = ReportTable()
    table.words("parameter", "unit")
    table.numbers("default")
    table.words("range", "meaning")
    for p in effect.parameters:
        possible = range_words(p.lower, p.upper)
        only = f"; with {effect.law}: {p.choice}" if p.choice else ""
        table.add_row(p.name, escape(p.unit), f"{p.default:g}", possible, escape(p.description + only))
    console.print(table)
    if is_own(effect):
        say("On a linear machine the same numbers hold in m for rad, in N for N m and in kg for kg m^2.")
    for option, choices in effect.options.items():
        say(f"option {option}: {effect.choices_in_words(option)} (default {choices[0]})")
    if effect.parameters:
        first = effect.parameters[0]
        console.print(
            f"\nema-twin add {name} --set {first.name}={first.default:g} --model polito_bench -o better.yaml",
            soft_wrap=True,
        )

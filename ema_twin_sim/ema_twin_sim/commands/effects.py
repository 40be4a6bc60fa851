"""``ema-twin effects``: the catalogue."""

from __future__ import annotations

from typing import Annotated

import typer
from rich.table import Table

from . import options
from .output import console

EXAMPLES = """Examples:

ema-twin effects

ema-twin effects backlash --json backlash.json"""


def run(
    id: Annotated[
        str | None,
        typer.Argument(metavar="ID", help="Show one effect in full.", autocompletion=options.effect_names),
    ] = None,
    json: options.JsonFile = None,
) -> None:
    """List the catalogue of physical effects: equation, parameters with units and bounds, what they look like."""
    from ..effects import catalogue, find_effect
    from .inputs import write_json

    chosen = [find_effect(id, "effects")] if id else list(catalogue().values())
    if id:
        _show_one(chosen[0])
    else:
        table = Table(pad_edge=False)
        for column in ("effect", "equation", "parameters", "what a residual shows"):
            table.add_column(column, overflow="fold")
        for effect in chosen:
            parameters = ", ".join(f"{p.name} [{p.unit}]" for p in effect.parameters)
            table.add_row(effect.id, effect.equation, parameters.replace("[", "\\["), effect.signature)
        console.print(table)
        console.print(
            "T torque, L dry friction level, b viscous coefficient, ω speed, θ angle: of the motor shaft; θ_o: output."
        )
        console.print("One effect in full: ema-twin effects ID. Add one: ema-twin add ID --model MODEL -o NEW.yaml")
    contents = [
        {
            "id": effect.id,
            "summary": effect.summary,
            "equation": effect.equation,
            "signature": effect.signature,
            "source": effect.source,
            "options": {name: list(choices) for name, choices in effect.options.items()},
            "parameters": {
                p.name: {
                    "unit": p.unit,
                    "default": p.default,
                    "lower": p.lower,
                    "upper": p.upper,
                    "text": p.description,
                }
                for p in effect.parameters
            },
        }
        for effect in chosen
    ]
    write_json(json, contents[0] if id else contents)


def _show_one(effect) -> None:
    console.print(f"[bold]{effect.id}[/bold]: {effect.summary}\n")
    console.print(f"  equation   {effect.equation}", markup=False)
    console.print(f"  residual   {effect.signature}", markup=False)
    console.print(f"  source     {effect.source}\n", markup=False)
    table = Table(pad_edge=False)
    for column in ("parameter", "unit", "default", "from", "to", "meaning"):
        table.add_column(column)
    for p in effect.parameters:
        table.add_row(p.name, p.unit, f"{p.default:g}", f"{p.lower:g}", f"{p.upper:g}", p.description)
    console.print(table)
    for name, choices in effect.options.items():
        console.print(f"option {name}: {', '.join(choices)} (default {choices[0]})")
    if effect.parameters:
        first = effect.parameters[0]
        console.print(
            f"\nema-twin add {effect.id} --set {first.name}={first.default:g} --model polito_bench -o better.yaml"
        )

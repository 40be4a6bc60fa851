"""``ema-twin remove``: write a model without one of its effects."""

from __future__ import annotations

from typing import Annotated

import typer

from . import options
from .output import console

EXAMPLES = """Examples:

ema-twin remove coulomb_friction --model polito_bench -o without.yaml

ema-twin remove coulomb_friction_2 --model polito_bench -o motor_side_only.yaml"""


def run(
    effect: Annotated[
        str,
        typer.Argument(
            metavar="EFFECT",
            help="An effect's id (all its instances), or ID_2 (one).",
            autocompletion=options.effects_of_model,
        ),
    ],
    model: options.ModelName,
    output: options.NewModel,
    with_files: options.WithFiles = None,
    force: options.Force = False,
) -> None:
    """Write a model without an effect."""
    from ..model import load_model, save_model
    from ..own_effects import load_effects

    load_effects(with_files or ())
    before = load_model(model)
    after = before.without_effect(effect)
    save_model(after, output, force=force)
    gone = ", ".join(name for name in before.effects if name not in after.effects)
    console.print(f"[bold]{gone}[/bold] removed from {before.name}, written to {output}", soft_wrap=True)

"""``ema-twin add``: a model with one more effect."""

from __future__ import annotations

from typing import Annotated

import typer

from ema_bench_replay.errors import InputError

from . import options
from .output import console, unfolded
from .tables import with_unit

EXAMPLES = """Examples:

ema-twin add backlash --set width=0.004 --model polito_bench -o better.yaml

ema-twin add viscous_friction --set coefficient=0.01 --set side=output --model better.yaml -o best.yaml

ema-twin add position_friction.py --set torque=0.1 --model polito_bench -o mine.yaml     (an effect of your own)"""


def run(
    effect: options.EffectName,
    model: options.ModelName,
    output: options.NewModel,
    set: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME=VALUE", help="A parameter or option; those not given take their defaults."),
    ] = None,
    with_files: options.WithFiles = None,
    force: options.Force = False,
) -> None:
    """Write a model with one more effect; parameters that are not given take the catalogue's typical values."""
    from ..effects import find_effect
    from ..model import load_model, save_model
    from ..own_effects import load_effect, load_effects
    from ..simulation.assembly import assemble

    load_effects(with_files or ())
    own = effect.endswith(".py")
    found = load_effect(effect) if own else find_effect(effect, "add")
    parameters: dict[str, object] = {}
    choices: dict[str, str] = {}
    for setting in set or []:
        name, equals, value = setting.partition("=")
        if not equals:
            raise InputError(f"--set {setting}: give NAME=VALUE, for example --set {found.parameters[0].name}=1")
        (choices if name in found.options else parameters)[name] = value
    before = load_model(model)
    after = before.with_effect(found.id, parameters, choices)  # type: ignore[arg-type]
    assemble(after)  # a model that cannot be simulated is refused here, not by the next command
    save_model(after, output, force=force)
    name = list(after.effects)[-1]
    instance = after.effects[name]
    console.print(f"[bold]{name}[/bold] added to {before.name}, written to {output}", soft_wrap=True)
    for parameter in found.parameters_with(instance.options):
        given = "given" if parameter.name in parameters else "typical value, not fitted"
        value = with_unit(instance.parameters[parameter.name], after.parameter_unit(found.id, parameter.name))
        console.print(f"  {parameter.name} = {value} ({given})")
    for option, choice in instance.options.items():
        console.print(f"  {option} = {choice}")
    if own:
        unfolded(f"Every command that reads {output} needs: --with {effect}")

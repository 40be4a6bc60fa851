"""``ema-twin fit``: fit the parameters of a model to recordings, with standard errors."""

from __future__ import annotations

from typing import Annotated

import typer

from . import options
from .output import say, status

EXAMPLES = """Examples:

ema-twin fit recordings --model better.yaml -o fitted.yaml

ema-twin fit runs/*.CSV --model better.yaml -o fitted.yaml --fix effects.backlash --json fit.json

ema-twin fit run.mcap --model mine.yaml -o fitted.yaml --free sensors.speed_smoothing

Paths are those of the ROS parameters: effects.backlash.width, machine.motor_inertia; effects.stribeck_friction\
 names all of its numbers."""


def run(
    runs: options.Runs,
    model: options.ModelName,
    output: options.NewModel,
    method: Annotated[
        str | None,
        typer.Option(
            help="equation (fit the torque that the measured motion needs) or simulation (simulate the closed loop of "
            "each recording); by default simulation, or equation if the current drives the twin."
        ),
    ] = None,
    free: Annotated[
        list[str] | None,
        typer.Option(
            metavar="PATH", help="Another parameter to fit, in addition to effects and inertias. May be repeated."
        ),
    ] = None,
    fix: Annotated[
        list[str] | None, typer.Option(metavar="PATH", help="Parameter or effect to keep fixed. May be repeated.")
    ] = None,
    input: options.Input = None,
    with_files: options.WithFiles = None,
    import_map: options.ImportMap = "siemens",
    start: options.From = None,
    end: options.To = None,
    strict: options.Strict = False,
    force: options.Force = False,
    json: options.JsonFile = None,
) -> None:
    """Fit the parameters of a model to recordings, with standard errors, and write the fitted model.

    Fits the parameters of the model's effects, and its inertias within their tolerances. The errors before and after
    are from recordings (or the last third of a single one) that were not used for fitting.
    """
    from ..model import save_model
    from .inputs import check_outputs, input_files, write_json

    check_outputs(input_files(runs, [model], import_map, with_files), force, model=output, json=json)

    from ..fitting.fit import fit_model
    from .judged import read_judged
    from .shown_fit import show_fit

    recordings, (before,), _ = read_judged(
        runs, [model], with_files, import_map=import_map, start=start, end=end, strict=strict, between_them=True
    )
    with status() as progress:
        found = fit_model(
            recordings, before, method=method, free=free or (), fix=fix or (), source=input, progress=progress
        )
    save_model(found.model, output, force=force)
    show_fit(found, before)
    say(f"\n{output} is the fitted model.")
    write_json(json, found.as_json())

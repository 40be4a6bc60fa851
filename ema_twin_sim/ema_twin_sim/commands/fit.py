"""``ema-twin fit``: the numbers of a model from recordings, with standard errors."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..quantities import estimate, quantity
from . import options
from .output import console, say, status, warn
from .tables import ReportTable
from .torque_errors import show_torque_errors
from .wording import effect_words, options_words

if TYPE_CHECKING:
    from ..fitting.findings import Finding
    from ..fitting.fit import FitResult
    from ..model import Model

EXAMPLES = """Examples:

ema-twin fit recordings --model better.yaml -o fitted.yaml

ema-twin fit runs/*.CSV --model better.yaml -o fitted.yaml --fix effects.backlash --json fit.json

ema-twin fit run.mcap --model mine.yaml -o fitted.yaml --free sensors.speed_smoothing

Paths are those of the ROS parameters: effects.backlash.width, machine.motor_inertia; effects.backlash names both\
 of its numbers."""

KINDS = {
    "on_bound": "On a bound",
    "no_effect": "Not shown",
    "inseparable": "Inseparable",
    "absurd": "Absurd",
}
"""The kinds of warnings, as headings."""


def run(
    runs: options.Runs,
    model: options.ModelName,
    output: Annotated[Path, typer.Option("-o", "--output", metavar="NEW", help="The model file to write.")],
    method: Annotated[
        str | None,
        typer.Option(
            "--method",
            help="equation (the torque that the measured motion needs) or simulation (the closed loop beside each "
            "recording); by default simulation, but equation where the current drives the twin.",
        ),
    ] = None,
    free: Annotated[
        list[str] | None,
        typer.Option("--free", metavar="PATH", help="A number to fit besides effects and inertias. May be repeated."),
    ] = None,
    fix: Annotated[
        list[str] | None,
        typer.Option("--fix", metavar="PATH", help="A number, or an effect, to hold as it is. May be repeated."),
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
    """Fit the numbers of a model to recordings, with standard errors, and write the model that has them.

    Free are the parameters of its effects, and its inertias within their tolerances. The errors before and after are
    those on recordings (or a last third) that the numbers were not fitted to.
    """
    from ..model import load_model, save_model
    from ..model.model_file import check_model_name
    from .inputs import input_files, load_runs, refuse_existing, refuse_inputs, write_json

    refuse_inputs(input_files(runs, [model], import_map, with_files), output, json)
    check_model_name(output)
    refuse_existing(force, output)

    from ..fitting.fit import fit_model
    from ..own_effects import load_effects

    load_effects(with_files or ())
    before = load_model(model)
    recordings = load_runs(runs, import_map=import_map, start=start, end=end, strict=strict, least=2)
    with status() as progress:
        found = fit_model(
            recordings, before, method=method, free=free or (), fix=fix or (), source=input, progress=progress
        )
    save_model(found.model, output, force=force)
    show(found, before)
    say(f"\n{output} is the fitted model.")
    write_json(json, found.as_json())


def show(found: FitResult, before: Model) -> None:
    """Print the fitted numbers beside those of the model ``before``, the errors, and what to make of them."""
    if found.parameters:
        console.print(_parameters(found, before))
    if found.constants:
        console.print(_constants(found))
    console.print(errors_table(found))
    show_torque_errors(found.torque_errors, found.model.motion)
    for note in found.notes:
        say(f"Note: {note}.")
    _warn(found.warnings)


def _parameters(found: FitResult, before: Model) -> ReportTable:
    table = ReportTable(f"Parameters, with standard errors (method {found.method})")
    table.words("effect", "options", "parameter")
    table.numbers("before", "fitted", justify="left")
    for name, entry in found.parameters.items():
        first = (effect_words(name), options_words(entry["options"]))
        for parameter, held in entry.items():
            if parameter in ("effect", "options"):
                continue
            old = estimate(before.effects[name].parameters[parameter], None, held["unit"])
            new = "held" if held["std"] is None else estimate(held["value"], held["std"], held["unit"])
            table.add_row(*first, parameter.replace("_", " "), old, new)
            first = ("", "")
    return table


def _constants(found: FitResult) -> ReportTable:
    table = ReportTable("\nConstants, within their tolerances")
    table.words("part", "constant")
    table.numbers("before", "fitted", justify="left")
    table.numbers("change")
    for part, entries in found.constants.items():
        for name, held in entries.items():
            before, fitted, change = estimate(held["nominal"], None, held["unit"]), "not in the data", ""
            if held["std"] is not None:
                fitted = estimate(held["value"], held["std"], held["unit"])
                change = f"{100.0 * (held['value'] / held['nominal'] - 1.0):+.1f} %"
            table.add_row(part, name.replace("_", " "), before, fitted, change)
    return table


def errors_table(found: FitResult) -> ReportTable:
    """The errors before and after, on what was not fitted to."""
    table = ReportTable(f"\nErrors: {found.judged_on}")
    table.words("signal")
    table.numbers("RMSE before", "after", "noise floor")
    for signal, error in found.before.items():
        if not error["driven"]:
            numbers = (error["rmse"], found.after[signal]["rmse"], error["noise_floor"])
            table.add_row(signal.replace("_", " "), *(quantity(number, error["unit"]) for number in numbers))
    return table


def _warn(warnings: Sequence[Finding]) -> None:
    """One line a warning; those of damaged recordings are told already, and one may stand for several numbers."""
    for kind, message in dict.fromkeys((w.kind, w.message) for w in warnings if w.kind in KINDS):
        warn(f"{KINDS[kind].lower()}: {message}")

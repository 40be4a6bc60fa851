"""``ema-twin report``: one page with what a model lacked, how sure that is, and the error that is left."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ema_bench_replay.errors import InputError

from ..listing import number_of
from . import options
from .output import status, unfolded, warn

EXAMPLES = """Examples:

ema-twin report recordings --model polito_bench --model better.yaml -o report.html

ema-twin report recordings --model polito_bench --model better.yaml --discovery found.json -o report.html

ema-twin report runs/*.CSV --model polito_bench --model better.yaml --held-out tuesday -o report.html

ema-twin report recordings --model polito_bench --model better.yaml --model fitted.yaml --fit fit.json -o report.html"""


def run(
    runs: options.Runs,
    model: Annotated[
        list[str],
        typer.Option(
            "--model",
            "-m",
            help="Two or three models: the original, the one that discover wrote, and the one that fit wrote from it.",
        ),
    ],
    output: Annotated[Path, typer.Option("-o", "--output", metavar="REPORT.html", help="The page to write.")],
    discovery: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.json",
            help="Output of discover --json (or diagnose --json); without it, the search is repeated.",
        ),
    ] = None,
    fit: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.json",
            help="Output of fit --json for the third model: standard errors, and errors on recordings that were not "
            "used for fitting.",
        ),
    ] = None,
    held_out: Annotated[
        list[Path] | None,
        typer.Option(metavar="RUN", help="Recordings that were not used for fitting. May be repeated."),
    ] = None,
    input: options.Input = None,
    with_files: options.WithFiles = None,
    import_map: options.ImportMap = "siemens",
    start: options.From = None,
    end: options.To = None,
    strict: options.Strict = False,
    force: options.Force = False,
) -> None:
    """Write a page for a colleague: what was wrong with a model, how sure that is, and what is left.

    One HTML file that needs no network: the models beside the recordings, where they fail, the diagnosis with its
    runners-up, the steps of the search, and the recording to make next. A third model is shown where fitting moved any
    number by more than its standard error.
    """
    from .inputs import check_outputs, input_files, load_runs

    if len(model) not in (2, 3):
        raise InputError(
            "report compares two models (before and after) or three (the second fitted, too): --model was given "
            f"{number_of(len(model), 'time')}"
        )
    if fit is not None and len(model) == 2:
        raise InputError(f"--fit {fit}: belongs to a third model; give that with --model")
    given = [*runs, *(held_out or ())]
    inputs = [*input_files(given, model, import_map, with_files), *filter(None, (discovery, fit))]
    check_outputs(inputs, force, page=output)

    from ..model import load_model
    from ..own_effects import load_effects
    from ..report.difference import check_same_effects
    from ..words.findings import read_findings
    from ..words.fit_findings import read_fit_findings
    from ..words.origin import refuse_foreign
    from .judged import with_noise_told, with_one_zero
    from .report_page import searched, write_page

    load_effects(with_files or ())
    models = [load_model(name) for name in model]
    if len(models) > 2:
        check_same_effects(models[1], models[2], (model[1], model[2]))
    recordings = with_one_zero(
        load_runs(runs, import_map=import_map, start=start, end=end, strict=strict, least=2), models[::-1]
    )
    models = [with_noise_told(recordings, given) for given in models]
    apart = (
        with_one_zero(load_runs(held_out, import_map=import_map, strict=strict, least=2), models[::-1])
        if held_out
        else []
    )

    names = [recording.name for recording in recordings]
    fitting = read_fit_findings(fit) if fit else None
    findings, undiagnosed = (read_findings(discovery), "") if discovery else (None, "")
    for option, file, result in (("--discovery", discovery, findings), ("--fit", fit, fitting)):
        if file is not None and result is not None:
            refuse_foreign(option, file, result.origin, models, names)
    with status() as progress:
        if discovery is None:
            findings, undiagnosed, recordings = searched(recordings, models[0], progress)
        progress("comparing the models, and writing the page")
        told = write_page(
            output,
            recordings,
            models,
            model,
            findings,
            fit=fitting,
            held_out=apart,
            source=input,
            undiagnosed=undiagnosed,
            force=force,
        )
    for text in (undiagnosed, *told):
        if text:
            warn(text)
    unfolded(f"{output} is the report: open it in any browser, or send it.")

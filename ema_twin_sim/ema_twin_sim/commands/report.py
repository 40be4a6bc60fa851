"""``ema-twin report``: one page that tells what a model lacked, how sure that is, and what is left."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ema_bench_replay.errors import InputError

from . import options
from .output import console, status, warn

if TYPE_CHECKING:
    from ema_bench_replay.recording import Recording

    from ..comparison.compare import Comparison
    from ..discovery.discover import Discovery
    from ..model import Model
    from ..report.findings import Findings
    from ..report.fitted import FitFindings

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
            help="The model before, then the model after (what discover wrote), then perhaps that one with its numbers "
            "fitted (what fit wrote): give two or three.",
        ),
    ],
    output: Annotated[Path, typer.Option("-o", "--output", metavar="REPORT.html", help="The page to write.")],
    discovery: Annotated[
        Path | None,
        typer.Option(
            "--discovery",
            metavar="FILE.json",
            help="What discover --json wrote (or diagnose --json); without it, the search is made again.",
        ),
    ] = None,
    fit: Annotated[
        Path | None,
        typer.Option(
            "--fit",
            metavar="FILE.json",
            help="What fit --json wrote of the third model: its standard errors, and how far off it is on recordings "
            "that it was not fitted to.",
        ),
    ] = None,
    held_out: Annotated[
        list[Path] | None,
        typer.Option("--held-out", metavar="RUN", help="Recordings that were not fitted to. May be repeated."),
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
    from ..model import load_model
    from ..own_effects import load_effects
    from ..report.findings import read_findings
    from ..report.fitted import check_same_effects, read_fit_findings
    from .inputs import input_files, load_runs, refuse_existing, refuse_inputs

    if len(model) not in (2, 3):
        raise InputError(
            "report compares two models, the one before and the one after, or three, that one with its numbers fitted "
            f"too: --model was given {len(model)} time{'s' if len(model) > 1 else ''}"
        )
    if fit is not None and len(model) == 2:
        raise InputError(f"--fit {fit}: tells of a third model; give that with --model")
    given = [*runs, *(held_out or ())]
    refuse_inputs([*input_files(given, model, import_map, with_files), *filter(None, (discovery, fit))], output)
    check_page_name(output)
    refuse_existing(force, output)
    load_effects(with_files or ())
    models = [load_model(name) for name in model]
    if len(models) > 2:
        check_same_effects(models[1], models[2], (model[1], model[2]))
    recordings = load_runs(runs, import_map=import_map, start=start, end=end, strict=strict, least=2)
    apart = load_runs(held_out, import_map=import_map, strict=strict, least=2) if held_out else []

    fitting = read_fit_findings(fit) if fit else None
    findings, undiagnosed = (read_findings(discovery), "") if discovery else (None, "")
    with status() as progress:
        if discovery is None:
            findings, undiagnosed = _searched(recordings, models[0], progress)
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
    console.print(f"{output} is the report: open it in any browser, or send it.", markup=False, soft_wrap=True)


def check_page_name(path: Path | None) -> None:
    """Raise InputError where the name of a report does not tell what it is."""
    if path is not None and path.suffix.lower() not in (".html", ".htm"):
        raise InputError(f"{path}: a report is a page; name it .html")


def write_page(
    output: Path,
    recordings: Sequence[Recording],
    models: Sequence[Model],
    labels: Sequence[str | Path],
    findings: Findings | None,
    *,
    fit: FitFindings | None = None,
    comparisons: Sequence[Comparison] = (),
    held_out: Sequence[Recording] = (),
    source: str | None = None,
    story: str = "",
    undiagnosed: str = "",
    force: bool = False,
) -> list[str]:
    """Compare two or three models with the recordings, and write the page; ``labels`` tell models of one name apart.

    A third model is left out where it differs from the second by no more than standard errors. ``comparisons`` are of
    all these models, where they were made already. Returns what the page doubts of the models. Raises InputError where
    a recording lacks the input's signal, or where the page cannot be written.
    """
    from ..report.backwards import backwards
    from ..report.content import Content, shown
    from ..report.page import write_report
    from ..version import VERSION

    names, note = told_apart(models, labels), ""
    if len(models) > 2 and not fitting_moved(models, findings, fit):
        note = f"{names[2]} is not shown: none of its numbers is farther from {names[1]}'s than its standard error."
        models, names, comparisons = models[:2], names[:2], comparisons[:2]
    given = shown(recordings, models, source, comparisons=comparisons)
    apart = shown(held_out, models, source) if held_out else None
    content = Content(tuple(models), names, given, apart, findings, VERSION, story, undiagnosed, fit, note)
    write_report(output, content, force=force)
    return [text for text in (backwards(content), note) if text]


def fitting_moved(models: Sequence[Model], findings: Findings | None, fit: FitFindings | None) -> bool:
    """Whether a number of the third model is farther from the second's than its standard error."""
    from ..report.fitted import two_values

    return any(each.differ for each in two_values(models[1], models[2], findings, fit))


def told_apart(models: Sequence[Model], labels: Sequence[str | Path]) -> tuple[str, ...]:
    """The models' names; where some are the same, those of their files."""
    for names in ([model.name for model in models], [Path(label).stem for label in labels]):
        if len(set(names)) == len(names):
            return tuple(names)
    return tuple(map(str, labels))


def weighed(found: Discovery) -> Findings:
    """The findings of a search that was made, with what its diagnosis weighs."""
    from ..discovery.diagnose import weigh
    from ..report.findings import findings_of

    return findings_of(found, weigh(found))


def _searched(
    recordings: Sequence[Recording], model: Model, progress: Callable[[str], None]
) -> tuple[Findings | None, str]:
    """What a search beside the recordings finds; or nothing, and why they cannot be judged."""
    from ..discovery.discover import discover

    try:
        found = discover(recordings, model, progress=progress)
    except InputError as refused:
        return None, f"no diagnosis: {refused}"
    progress("weighing what was found")
    return weighed(found), ""

"""``ema-twin discover``: which effects a model lacks, and the model that has them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from shlex import quote
from typing import Annotated

import typer

from . import options
from .output import say, status, unfolded

EXAMPLES = """Examples:

ema-twin discover recordings --model polito_bench -o better.yaml

ema-twin discover runs/*.CSV --model polito_bench -o better.yaml --json found.json --report found.html

ema-twin discover recordings --model polito_bench -o better.yaml --without spring_load --with position_friction.py"""


def run(
    runs: options.Runs,
    model: options.ModelName,
    output: Annotated[
        Path, typer.Option("-o", "--output", metavar="NEW", help="The model file to write: effects and constants.")
    ],
    with_files: options.WithFiles = None,
    without: options.Without = None,
    import_map: options.ImportMap = "siemens",
    start: options.From = None,
    end: options.To = None,
    strict: options.Strict = False,
    evidence: options.Evidence = None,
    report: Annotated[Path | None, typer.Option(metavar="FILE.html", help="Also write the HTML report.")] = None,
    rrd: options.Rrd = None,
    force: options.Force = False,
    json: options.JsonFile = None,
) -> None:
    """Find the effects that a model lacks, fit them, and write the model that has them.

    Effects are added one after another as long as each explains more than its parameters cost, and judged on recordings
    that they were not fitted to. The verdict may be that nothing is missing, or that no effect of the catalogue
    explains what is left.
    """
    from ..model import save_model
    from .inputs import check_outputs, input_files

    inputs = input_files(runs, [model], import_map, with_files)
    check_outputs(inputs, force, model=output, json=json, evidence=evidence, page=report, rrd=rrd)

    from ..discovery.discover import discover
    from .judged import read_judged, warn_of, write_evidence_bag, write_findings
    from .shown_search import show_doubts, show_search

    recordings, (before,), excluded = read_judged(
        runs, [model], with_files, without, import_map=import_map, start=start, end=end, strict=strict
    )
    with status() as progress:
        found = discover(recordings, before, without=excluded, progress=progress)
        save_model(found.model, output, force=force)
        if evidence is not None:
            progress("writing the evidence")
            write_evidence_bag(found, evidence, force=force)
        both, labels, findings = (before, found.model), (model, output), None
        if report is not None or rrd is not None:
            from .report_page import weighed, write_page

            progress("computing probabilities")
            findings = weighed(found)
        if report is not None:
            progress("writing the report")
            write_page(report, found.given, both, labels, findings, force=force)
        if rrd is not None:
            from .rerun_file import tell_of_rrd, write_rrd

            progress("writing the views")
            tabs = write_rrd(rrd, found.given, both, labels, findings, force=force)
        progress("looking for what to record next")
        next_recording = found.next_recording
    warn_of(found.misread, recordings)
    show_search(found, excluded)
    show_doubts(found.groups, next_recording, found.model.motion)
    say(f"\nThe search ended: {found.stopped}.")
    warn_of(found.warnings, recordings, told=found.misread)
    shown: list[str | Path] = [model]
    if found.added or found.constants:
        shown.append(output)
        say(f"\n{output} is the new model. To see its errors:")
    else:
        say(f"\n{output} equals {model}: no effect was found that improves it. To see where it fails:")
    unfolded(f"  {compare_command(runs, shown, with_files or (), import_map)}")
    if evidence is not None:
        axis = "; operating points are drawn over position, 1 s per radian" if recordings[0].of_points else ""
        unfolded(f"  rerun {quote(str(evidence))}     (residuals of each step{axis})")
    if report is not None:
        unfolded(f"  {report}     (HTML report, before and after)")
    if rrd is not None:
        tell_of_rrd(rrd, tabs)
    write_findings(json, found.as_json(), found)


def compare_command(
    runs: Sequence[Path], models: Sequence[str | Path], with_files: Sequence[Path] = (), import_map: str = "siemens"
) -> str:
    """Shell command that compares the models with the recordings, quoted."""
    models_named = [part for model in models for part in ("--model", quote(str(model)))]
    own = [part for file in with_files for part in ("--with", quote(str(file)))]
    read_by = [] if import_map == "siemens" else ["--map", quote(import_map)]
    return " ".join(["ema-twin", "compare", *_as_arguments(runs), *models_named, *own, *read_by])


def _as_arguments(runs: Sequence[Path]) -> list[str]:
    """Files as shell arguments; more than two become one glob pattern if it matches exactly these files."""
    suffix, folder = runs[0].suffix, runs[0].parent
    if len(runs) > 2 and suffix and folder.is_dir():
        there = {file for file in folder.iterdir() if file.suffix == suffix and not file.name.startswith(".")}
        if there == set(runs):
            return [f"*{suffix}" if folder == Path() else f"{quote(str(folder))}/*{suffix}"]
    return [quote(str(run)) for run in runs]

"""``ema-twin discover``: which effects a model lacks, and the model that has them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.markup import escape

from ..quantities import estimate, quantity
from . import options
from .output import console, say, status
from .tables import ReportTable, is_narrow
from .wording import (
    REFIT,
    REFIT_IS,
    change_words,
    effect_words,
    groups_sentence,
    has_moved,
    left_sentence,
    options_words,
    order_sentences,
    refit_sentence,
    removed_words,
    verdict_of,
    why_step,
)

if TYPE_CHECKING:
    from ..discovery.discover import Discovery

EXAMPLES = """Examples:

ema-twin discover recordings --model polito_bench -o better.yaml

ema-twin discover runs/*.CSV --model polito_bench -o better.yaml --json found.json --report found.html

ema-twin discover recordings --model polito_bench -o better.yaml --without spring_load --with position_friction.py"""

STEPS_ARE = (
    "Excess: the mean square of the error above that of the sensors' noise; where 99 % of it goes, a tenth of the RMSE "
    "stays. Runner-up: the second-best effect in that step, and its gain as a share of the step's."
)
"""What the columns of the table of steps are."""
_LEAST_CHANGE = 0.0005  # of a constant: a smaller one is shown as none


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
    report: Annotated[
        Path | None, typer.Option("--report", metavar="FILE.html", help="Also write the HTML report.")
    ] = None,
    rrd: options.Rrd = None,
    force: options.Force = False,
    json: options.JsonFile = None,
) -> None:
    """Find the effects that a model lacks, fit them, and write the model that has them.

    Effects are added one after another as long as each is worth its price, and judged on recordings that they were not
    fitted to. The verdict may be that nothing is missing, or that no effect of the catalogue explains what is left.
    """
    from ..model import save_model
    from ..model.model_file import check_model_name
    from .inputs import input_files, refuse_evidence, refuse_existing, refuse_inputs
    from .judged import read_judged, warn_of, write_evidence_bag, write_findings
    from .report import check_page_name, weighed, write_page
    from .rerun_file import check_rrd_name, tell_of_rrd, write_rrd

    refuse_inputs(input_files(runs, [model], import_map, with_files), output, json, evidence, report, rrd)
    check_model_name(output)
    refuse_evidence(evidence)
    check_page_name(report)
    check_rrd_name(rrd)
    refuse_existing(force, output, evidence, report, rrd)

    from ..discovery.discover import discover

    given = read_judged(runs, model, with_files, without, import_map=import_map, start=start, end=end, strict=strict)
    with status() as progress:
        found = discover(given.recordings, given.model, without=given.without, progress=progress)
        save_model(found.model, output, force=force)
        if evidence is not None:
            progress("writing the evidence")
            write_evidence_bag(found, given.recordings, evidence, force=force)
        both, labels, findings = (given.model, found.model), (model, output), None
        if report is not None or rrd is not None:
            progress("weighing what was found")
            findings = weighed(found)
        if report is not None:
            progress("writing the report")
            write_page(report, given.recordings, both, labels, findings, force=force)
        if rrd is not None:
            progress("writing the views")
            tabs = write_rrd(rrd, given.recordings, both, labels, findings, force=force)
    show(found, given.without)
    show_doubts(found.groups, found.next_recording)
    say(f"\nThe search ended: {found.stopped}.")
    warn_of(found.warnings, given.recordings)
    is_new = bool(found.added or found.constants)
    for line in _written(output, model, is_new=is_new):
        say(line)
    shown: list[str | Path] = [model, output] if is_new else [model]
    console.print(f"  {compare_command(runs, shown, with_files or (), import_map)}", markup=False, soft_wrap=True)
    if evidence is not None:
        axis = "; points over their position, a second for each radian" if given.recordings[0].of_points else ""
        told = f"  rerun {quote(str(evidence))}     (what each step left over{axis})"
        console.print(told, markup=False, soft_wrap=True)
    if report is not None:
        console.print(f"  {report}     (before and after, to be sent)", markup=False, soft_wrap=True)
    if rrd is not None:
        tell_of_rrd(rrd, tabs)
    write_findings(json, found.as_json(), found)


def _written(output: Path, model: str, *, is_new: bool) -> list[str]:
    """What the written model is, and what the command beneath shows of it."""
    if is_new:
        return [f"\n{output} is the new model. See how far off it is:"]
    return [f"\n{output} is the same as {model}: nothing found betters it. See where it fails:"]


def compare_command(
    runs: Sequence[Path],
    models: Sequence[str | Path],
    with_files: Sequence[Path] = (),
    import_map: str = "siemens",
) -> str:
    """The command that shows models beside recordings, as a shell takes it."""
    models_named = [part for model in models for part in ("--model", quote(str(model)))]
    own = [part for file in with_files for part in ("--with", quote(str(file)))]
    read_by = [] if import_map == "siemens" else ["--map", quote(import_map)]
    return " ".join(["ema-twin", "compare", *_as_arguments(runs), *models_named, *own, *read_by])


def _as_arguments(runs: Sequence[Path]) -> list[str]:
    """Files as arguments: several as one pattern where that stands for them and no other."""
    suffix, folder = runs[0].suffix, runs[0].parent
    if len(runs) > 2 and suffix and folder.is_dir():
        there = {file for file in folder.iterdir() if file.suffix == suffix and not file.name.startswith(".")}
        if there == set(runs):
            return [f"*{suffix}" if folder == Path() else f"{quote(str(folder))}/*{suffix}"]
    return [quote(str(run)) for run in runs]


def show(found: Discovery, without: Sequence[str] = ()) -> None:
    """Print the verdict in one sentence, the steps that led there, and the numbers."""
    say(verdict_of(found, without=without), style="bold")
    if found.verdict == "unknown":
        left = found.unseen
        say(
            f"What is left over: {quantity(left.rmse[-1], left.unit)} of the {left.signal.replace('_', ' ')}, where "
            f"the sensors' noise makes {quantity(left.noise_floor, left.unit)}."
        )
    if found.unseen.refitted and not found.steps:
        say(refit_sentence(found.unseen))
    if found.steps:
        console.print(_steps(found))
        say(STEPS_ARE)
        if leaves := left_sentence(found.unseen):
            say(leaves)
        if _is_crowded(found):
            for step in found.steps:
                what = "Runner-up to" if step.action == "add" else "Dropped:"
                say(f"{what} {effect_words(step.instance)}: {why_step(step)}.")
    if found.parameters:
        console.print(_parameters(found))
    for sentence in order_sentences(found.model, found.parameters):
        say(sentence)
    moved = _constants(found)
    if moved.row_count:
        console.print(moved)
    slightly = _moved_slightly(found)
    if slightly:
        say(f"\n{'Also refitted' if moved.row_count else 'Refitted'}, within standard errors: {', '.join(slightly)}.")


def show_doubts(groups: Sequence[Sequence[str]], next_recording: str) -> None:
    """Print what the recordings cannot tell apart, and the recording to make next."""
    if groups:
        say(f"\n{groups_sentence(groups)}")
    if next_recording:
        say(f"\nRecord next: {next_recording}")


def _steps(found: Discovery) -> ReportTable:
    from ..effects import catalogue
    from ..measured.folds import HALF_OF

    several = len(found.unseen.recordings) > 1
    judged_on = f"recordings that were {'not ' if several else ''}fitted to"
    if HALF_OF in found.recordings[0].metadata:
        judged_on = "the half of the points that was not fitted to"
    signal = found.unseen.signal.replace("_", " ")
    floor = quantity(found.unseen.noise_floor, found.unseen.unit)
    table = ReportTable(f"\nSteps, judged by the {signal} of {judged_on} (noise floor {floor})")
    narrow, output, crowded = is_narrow(), _has_output(found), _is_crowded(found)
    table.words("step", *(() if narrow else ("what it is",)), widest=44)
    shown = "encoders apart" if found.unseen.encoders else "output position"
    table.numbers("RMSE before", "after", "excess removed", *((f"{shown} before", "after") if output else ()))
    table.words(*(() if crowded else ("runner-up",)))
    unseen = found.unseen
    if unseen.refitted:
        outputs = (unseen.given_output, unseen.output[0]) if output and unseen.given_output is not None else ()
        table.add_row(
            REFIT,
            *(() if narrow else (REFIT_IS,)),
            quantity(unseen.given, unseen.unit),
            quantity(unseen.rmse[0], unseen.unit),
            removed_words(unseen.refit_removed, unseen.given, unseen.rmse[0]),
            *(quantity(value, "rad") for value in outputs),
            *(() if crowded else ("",)),
        )
        table.add_section()
    for step in found.steps:
        if step.action != "add":  # in the same round as what made it needless, and its numbers are that round's
            blank = [""] * (len(table.columns) - 2 if narrow else 0)
            table.add_row(f"− {effect_words(step.instance)}", *(() if crowded else (*blank, escape(why_step(step)))))
            continue
        table.add_row(
            f"+ {effect_words(step.instance)}",
            *(() if narrow else (escape(catalogue()[step.effect].summary),)),
            quantity(step.rmse_before, step.unit),
            quantity(step.rmse_after, step.unit),
            removed_words(step.error_removed, step.rmse_before, step.rmse_after),
            *(quantity(value, "rad") for value in (step.output_before, step.output_after) if value is not None),
            *(() if crowded else (escape(why_step(step)),)),
        )
    return table


def _has_output(found: Discovery) -> bool:
    """Whether the steps tell of the output's position too."""
    return any(step.output_before is not None for step in found.steps)


def _is_crowded(found: Discovery) -> bool:
    """Whether the table of the steps has no room for words on them."""
    return is_narrow() and _has_output(found)


def _parameters(found: Discovery) -> ReportTable:
    table = ReportTable("\nParameters, with standard errors")
    table.words("effect", "options", "parameter")
    table.numbers("value", justify="left")
    for name, entry in found.parameters.items():
        first = (effect_words(name), options_words(entry["options"]))
        for parameter, held in entry.items():
            if parameter not in ("effect", "options"):
                fitted = "" if held["std"] is not None else " (typical value, not fitted)"
                table.add_row(*first, parameter, f"{estimate(held['value'], held['std'], held['unit'])}{fitted}")
                first = ("", "")
    return table


def _constants(found: Discovery) -> ReportTable:
    """The constants that moved by more than their standard error."""
    table = ReportTable("\nConstants that were refitted")
    table.words("part", "constant")
    table.numbers("in your model", "refitted", justify="left")
    table.numbers("change")
    constants: Mapping[str, Mapping[str, Any]] = found.constants
    for part, entries in constants.items():
        for name, held in entries.items():
            value, nominal, std = held["value"], held["nominal"], held["std"]
            if has_moved(held):
                numbers = (estimate(nominal, None, held["unit"]), estimate(value, std, held["unit"]))
                table.add_row(effect_words(part), name.replace("_", " "), *numbers, change_words(held))
    return table


def _moved_slightly(found: Discovery) -> list[str]:
    """The constants that moved by less than their standard error: ``motor inertia +0.4 %``."""
    from ..model.constants import PARTS

    moved = []
    constants: Mapping[str, Mapping[str, Any]] = found.constants
    for part, entries in constants.items():
        for name, held in entries.items():
            distance = abs(held["value"] - held["nominal"])
            if held["nominal"] and _LEAST_CHANGE * abs(held["nominal"]) < distance <= (held["std"] or 0.0):
                named = name.replace("_", " ") if part in PARTS else effect_words(part)
                moved.append(f"{named} {change_words(held)}")
    return moved

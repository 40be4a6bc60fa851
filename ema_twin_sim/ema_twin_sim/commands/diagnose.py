"""``ema-twin diagnose``: which effect a model lacks, the likeliest first."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..words.ranking import ranked_words, size_words, worth_showing
from ..words.sentences import (
    NOT_IN_CATALOGUE,
    no_effect_words,
    order_sentences,
    removed_words,
    surest_sentence,
    verdict_of,
)
from . import options
from .output import console, say, status
from .tables import ReportTable, is_narrow

if TYPE_CHECKING:
    from ..discovery.diagnose import Diagnosis

EXAMPLES = """Examples:

ema-twin diagnose recordings --model polito_bench

ema-twin diagnose run.mcap --model better.yaml --json diagnosis.json --evidence diagnosis.mcap

ema-twin diagnose recordings --model polito_bench --with position_friction.py --without gravity_load"""

_BAR = 20


def run(
    runs: options.Runs,
    model: options.ModelName,
    with_files: options.WithFiles = None,
    without: options.Without = None,
    import_map: options.ImportMap = "siemens",
    start: options.From = None,
    end: options.To = None,
    strict: options.Strict = False,
    evidence: options.Evidence = None,
    rrd: options.Rrd = None,
    force: options.Force = False,
    json: options.JsonFile = None,
) -> None:
    """Rank the effects that a model may lack: how likely each is, and how much of the error it removes.

    Several effects may be missing at once; each has its own probability. diagnose writes no model: use discover for
    that.
    """
    from .inputs import check_outputs, input_files

    inputs = input_files(runs, [model], import_map, with_files)
    check_outputs(inputs, force, json=json, evidence=evidence, rrd=rrd)

    from ..discovery.diagnose import weigh
    from ..discovery.discover import discover
    from ..words.findings import findings_of
    from .judged import read_judged, warn_of, write_evidence_bag, write_findings

    recordings, (before,), excluded = read_judged(
        runs, [model], with_files, without, import_map=import_map, start=start, end=end, strict=strict
    )
    with status() as progress:
        found = discover(recordings, before, without=excluded, progress=progress)
        progress("computing probabilities")
        diagnosis = weigh(found)
        if evidence is not None:
            progress("writing the evidence")
            write_evidence_bag(found, recordings, evidence, force=force)
        if rrd is not None:
            from .rerun_file import tell_of_rrd, write_rrd

            progress("writing the views")
            both = (before, found.model)
            labels = (before.name, "with the effects found")
            tabs = write_rrd(rrd, recordings, both, labels, findings_of(found, diagnosis), force=force)
        progress("looking for what to record next")
        content = diagnosis.as_json()
    warn_of(diagnosis.misread, recordings)
    say(verdict_of(found, without=excluded), style="bold")
    show(diagnosis, before.motion)
    for text in order_sentences(found.model, found.parameters):
        say(text)
    warn_of(diagnosis.warnings, recordings, told=diagnosis.misread)
    write_findings(json, content, found)
    if rrd is not None:
        tell_of_rrd(rrd, tabs)


def show(diagnosis: Diagnosis, motion: str = "rotary") -> None:
    """Print the ranking and what is in doubt."""
    from .shown_search import show_doubts

    table = ReportTable("\nWhat the model may lack")
    table.words("effect")
    table.numbers("probability", justify="left")
    table.numbers("error removed")
    table.words("parameters")
    shown, left_out = worth_showing(diagnosis.ranking)
    for entry in shown:
        removed = "" if entry.error_removed is None else removed_words(entry.error_removed)
        style = "bold green" if entry.found else ("" if entry.probability > 0.0 else "dim")
        table.add_row(ranked_words(entry), _bar(entry.probability), removed, "\n".join(size_words(entry)), style=style)
    table.add_section()
    for label, probability in (
        (no_effect_words(diagnosis.beyond_noise), diagnosis.none),
        (NOT_IN_CATALOGUE, diagnosis.unknown),
    ):
        table.add_row(label, _bar(probability), "", "", style="" if probability > 0.0 else "dim")
    console.print(table)
    if diagnosis.ranking:
        say(
            "Probability: that this effect is missing; several may be missing at once, and those that the "
            "recordings cannot tell apart share one. Error removed: share of the error above the sensors' noise that "
            "this effect removes in addition to all others found, on data not used for fitting (discover counts its "
            f"steps one after another). {surest_sentence()}"
            + (f" {left_out} more with probability 0 are not listed (they are in --json)." if left_out else ""),
            style="dim",
        )
    show_doubts(diagnosis.groups, diagnosis.next_recording, motion)


def _bar(probability: float) -> str:
    longest = _BAR // 4 if is_narrow() else _BAR
    return f"{100.0 * probability:3.0f} % {'█' * round(longest * probability)}"

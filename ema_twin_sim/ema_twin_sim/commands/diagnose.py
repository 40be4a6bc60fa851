"""``ema-twin diagnose``: which effect a model lacks, the likeliest first."""

from __future__ import annotations

from . import options
from .output import say, status

EXAMPLES = """Examples:

ema-twin diagnose recordings --model polito_bench

ema-twin diagnose run.mcap --model better.yaml --json diagnosis.json --evidence diagnosis.mcap

ema-twin diagnose recordings --model polito_bench --with position_friction.py --without gravity_load"""


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
    from ..words.sentences import order_sentences, verdict_of
    from .judged import read_judged, warn_of, write_evidence_bag, write_findings
    from .shown_diagnosis import show_diagnosis

    recordings, (before,), excluded = read_judged(
        runs, [model], with_files, without, import_map=import_map, start=start, end=end, strict=strict
    )
    with status() as progress:
        found = discover(recordings, before, without=excluded, progress=progress)
        progress("computing probabilities")
        diagnosis = weigh(found)
        if evidence is not None:
            progress("writing the evidence")
            write_evidence_bag(found, evidence, force=force)
        if rrd is not None:
            from .rerun_file import tell_of_rrd, write_rrd

            progress("writing the views")
            both = (before, found.model)
            labels = (before.name, "with the effects found")
            tabs = write_rrd(rrd, found.given, both, labels, findings_of(found, diagnosis), force=force)
        progress("looking for what to record next")
        content = diagnosis.as_json()
    warn_of(diagnosis.misread, recordings)
    say(verdict_of(found, without=excluded), style="bold")
    show_diagnosis(diagnosis, before.motion)
    for text in order_sentences(found.model, found.parameters):
        say(text)
    warn_of(diagnosis.warnings, recordings, told=diagnosis.misread)
    write_findings(json, content, found)
    if rrd is not None:
        tell_of_rrd(rrd, tabs)

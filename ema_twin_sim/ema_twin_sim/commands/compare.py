"""``ema-twin compare``: residual and RMSE per signal next to the noise floor, and where a model fails."""

from __future__ import annotations

from ema_bench_replay.errors import InputError

from . import options
from .output import counted, say, status

EXAMPLES = """Examples:

ema-twin compare bench/*.CSV --model polito_bench

ema-twin compare bench/*.CSV --model polito_bench --model better.yaml --json errors.json     (side by side)

ema-twin compare run.mcap --model polito_bench --rrd run.rrd     (then: rerun run.rrd)

ema-twin compare run.mcap --model mine.yaml --with position_friction.py"""

_MOST_MODELS = 3
"""Number of models that the views show side by side."""


def run(
    runs: options.Runs,
    model: options.Models,
    input: options.Input = None,
    with_files: options.WithFiles = None,
    import_map: options.ImportMap = "siemens",
    start: options.From = None,
    end: options.To = None,
    step: options.Step = None,
    strict: options.Strict = False,
    rrd: options.Rrd = None,
    force: options.Force = False,
    json: options.JsonFile = None,
) -> None:
    """Compare models with recordings: RMSE per signal next to the sensors' noise floor, and where the model fails."""
    from .inputs import check_outputs, input_files, write_json

    check_outputs(input_files(runs, model, import_map, with_files), force, json=json, rrd=rrd)
    if rrd is not None and len(model) > _MOST_MODELS:
        raise InputError(f"--rrd {rrd}: shows one to three models side by side; --model was given {len(model)} times")

    from ..comparison.closeness import closer
    from ..comparison.compare import compare_all
    from ..words.open_values import open_values_sentence
    from .judged import read_judged, warn_of
    from .shown_comparison import show_comparison

    recordings, models, _ = read_judged(
        runs, model, with_files, import_map=import_map, start=start, end=end, strict=strict
    )
    with counted(len(models) * len(recordings), "comparing") as done:
        comparisons = compare_all(
            recordings,
            models,
            input,
            step=step,
            progress=lambda model, recording: done(f"{model}, {recording}"),
            within=lambda model, recording, share: done.within(f"{model}, {recording}", share),
        )
    misread = dict.fromkeys(text for c in comparisons for text in c.misread)
    warn_of(misread, recordings)
    for given in models:
        if said := open_values_sentence(given, recordings):
            say(said)
    show_comparison(comparisons, labels=model, start=start or 0.0)
    warned = dict.fromkeys(text for c in comparisons for text in c.warnings)
    warn_of(warned, recordings, told=misread)
    first, *others = comparisons
    beside = [{**other.as_json(), "times_closer": closer(first, other).as_json()} for other in others]
    write_json(json, [first.as_json(), *beside] if beside else first.as_json())
    if rrd is not None:
        from .rerun_file import tell_of_rrd, write_rrd

        with status() as progress:
            progress("writing the views")
            tabs = write_rrd(
                rrd, recordings, models, model, source=input, step=step, comparisons=comparisons, force=force
            )
        tell_of_rrd(rrd, tabs)

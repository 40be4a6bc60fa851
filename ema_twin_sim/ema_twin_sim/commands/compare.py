"""``ema-twin compare``: residual and RMSE per signal beside the noise floor, and where a model fails."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from rich.markup import escape

from ..quantities import quantity
from . import options
from .output import console, progress_bar, say, sparkline
from .tables import ReportTable, is_narrow
from .torque_errors import show_torque_errors

if TYPE_CHECKING:
    from ..comparison.compare import Comparison
    from ..comparison.running_comparison import SignalError
    from ..comparison.where import Dependence

EXAMPLES = """Examples:

ema-twin compare bench/*.CSV --model polito_bench

ema-twin compare run.mcap --model polito_bench --model better.yaml --json errors.json

ema-twin compare run.mcap --model mine.yaml --with position_friction.py"""

AT_NOISE = 1.1
"""An RMSE up to this many noise floors counts as the sensors' noise."""
OPEN_LOOP = ("speed", "motor_position", "output_position")
"""Signals that drift under the input ``current``, where nothing holds the twin's motion to the bench's."""


def run(
    runs: options.Runs,
    model: options.Models,
    input: options.Input = None,
    with_files: options.WithFiles = None,
    import_map: options.ImportMap = "siemens",
    start: options.From = None,
    end: options.To = None,
    strict: options.Strict = False,
    json: options.JsonFile = None,
) -> None:
    """Compare models with recordings: RMSE per signal beside the sensors' noise floor, and where the model fails."""
    from ..comparison.compare import compare
    from ..model import load_model
    from ..own_effects import load_effects
    from .inputs import input_files, load_runs, refuse_inputs, write_json
    from .judged import warn_of

    refuse_inputs(input_files(runs, model, import_map, with_files), json)
    load_effects(with_files or ())
    models = [load_model(name) for name in model]
    recordings = load_runs(runs, import_map=import_map, start=start, end=end, strict=strict, least=2)
    comparisons = []
    with progress_bar() as progress:
        task = progress.add_task("comparing", total=len(models) * len(recordings))
        for each in models:
            comparisons.append(compare(recordings, each, input, progress=lambda _: progress.advance(task)))
    show(comparisons, labels=model)
    warn_of(list(dict.fromkeys(text for c in comparisons for text in c.warnings)), recordings)
    contents = [comparison.as_json() for comparison in comparisons]
    write_json(json, contents[0] if len(contents) == 1 else contents)


def show(comparisons: Sequence[Comparison], labels: Sequence[str] = ()) -> None:
    """Print the RMSE table of all models, then where each fails; ``labels`` tell models of one name apart."""
    names = [comparison.model for comparison in comparisons]
    if labels and len(set(names)) < len(names):
        comparisons = [replace(c, model=label) for c, label in zip(comparisons, labels, strict=True)]
    errors = _errors(comparisons)
    if errors.fits():
        console.print(errors)
    else:
        _show_errors_below_each_other(comparisons)
    if comparisons[0].input == "current":
        say("The current drives the twin open loop: its speed and positions drift and are left out (JSON has them).")
    for comparison in comparisons:
        torques = {r.name: r.torque_error for r in comparison.recordings if r.torque_error is not None}
        show_torque_errors(torques, comparison.motion, comparison.model if len(comparisons) > 1 else "")
    for comparison in comparisons:
        _show_where(comparison, titled=len(comparisons) > 1)


def _errors(comparisons: Sequence[Comparison]) -> ReportTable:
    first = comparisons[0]
    names = shown_signals(first.input, first.overall)
    several = len(comparisons) > 1
    table = ReportTable(f"RMSE, measured minus twin (input: {first.input})")
    table.words("recording", *(["model"] if several else []))
    table.numbers(*(name.replace("_", " ") for name in names))
    floors = [quantity(first.overall[n]["noise_floor"], first.overall[n]["unit"]) for n in names]
    table.add_row("noise floor of the sensors", *([""] if several else []), *floors, style="dim")
    table.add_section()
    for row, recording in enumerate(first.recordings):
        for k, comparison in enumerate(comparisons):
            signals = comparison.recordings[row].signals
            label = [recording.name if k == 0 else ""] + ([comparison.model] if several else [])
            last = several and k == len(comparisons) - 1
            table.add_row(*label, *(_cell(signals.get(n)) for n in names), end_section=last)
    table.add_section()
    for k, comparison in enumerate(comparisons):
        label = ["all recordings" if k == 0 else ""] + ([comparison.model] if several else [])
        table.add_row(*label, *(_cell(comparison.overall.get(n)) for n in names), style="bold")
    for comparison in comparisons[1:]:
        shares = (_removed(first.overall[n], comparison.overall.get(n)) for n in names)
        table.add_row("excess over noise removed", comparison.model, *shares, style="bold green")
    return table


def _show_errors_below_each_other(comparisons: Sequence[Comparison]) -> None:
    """The table of ``_errors`` where it is too wide for the terminal: a section a recording, its signals in rows."""
    first = comparisons[0]
    names = shown_signals(first.input, first.overall)
    say(f"RMSE, measured minus twin (input: {first.input})", style="table.title")
    for row, recording in enumerate(first.recordings):
        say(recording.name, style="bold")
        each = [comparison.recordings[row].signals for comparison in comparisons]
        console.print(_signals_in_rows(names, [comparison.model for comparison in comparisons], each))
    say("all recordings", style="bold")
    table = _signals_in_rows(names, [c.model for c in comparisons], [c.overall for c in comparisons])
    console.print(table)
    for comparison in comparisons[1:]:
        shares = {n: _removed(first.overall[n], comparison.overall.get(n)) for n in names}
        removed = ", ".join(f"{name.replace('_', ' ')} {share}" for name, share in shares.items())
        say(f"Excess over noise removed by {comparison.model}: {removed}.", style="bold green")


def _signals_in_rows(
    names: Sequence[str], models: Sequence[str], signals: Sequence[Mapping[str, SignalError]]
) -> ReportTable:
    table = ReportTable()
    table.words("signal")
    table.numbers("noise floor", *map(escape, models), least=len("99.7 mrad/s"))
    for name in names:
        floor = next((held[name] for held in signals if name in held), None)
        shown = "–" if floor is None else quantity(floor["noise_floor"], floor["unit"])
        table.add_row(name.replace("_", " "), shown, *(_cell(held.get(name)) for held in signals))
    return table


def shown_signals(source: str, signals: Mapping[str, SignalError]) -> list[str]:
    """The signals whose errors tell something under an input."""
    left_out = OPEN_LOOP if source == "current" else ()
    return [name for name, signal in signals.items() if not signal["driven"] and name not in left_out]


def _cell(signal: SignalError | None) -> str:
    if signal is None:
        return "–"
    ratio = signal["rmse"] / signal["noise_floor"] if signal["noise_floor"] else math.inf
    style = "green" if ratio <= AT_NOISE else ("yellow" if ratio <= 3.0 else "red")
    return f"[{style}]{quantity(signal['rmse'], signal['unit'])}[/{style}]"


def _removed(before: SignalError, after: SignalError | None) -> str:
    from ..comparison.running_comparison import excess_removed

    share = None if after is None else excess_removed(before, after)
    return "–" if share is None else f"{100.0 * share:.1f} %"


def _show_where(comparison: Comparison, *, titled: bool) -> None:
    from ..comparison.where import FEWEST_SAMPLES

    of = f" ({comparison.model})" if titled else ""
    overall = comparison.overall
    shown = shown_signals(comparison.input, overall)
    poor = {n for n in shown if overall[n]["rmse"] > AT_NOISE * overall[n]["noise_floor"]}
    found = [d for d in comparison.where if d.signal in poor]
    few = sum(recording.samples for recording in comparison.recordings) < FEWEST_SAMPLES
    if not poor and few:
        short = f"this is too short to tell, which takes {FEWEST_SAMPLES} samples"
        say(f"\nNo error stands out of the sensors' noise{of}, but {short}.")
        return
    if not poor:
        say(f"\nAll errors are at the sensors' noise floor{of}: nothing left to find.")
        return
    if not found:
        names = ", ".join(sorted(name.replace("_", " ") for name in poor))
        why = (
            f"this is too short to tell where, which takes {FEWEST_SAMPLES} samples"
            if few
            else "where cannot be told: that takes the current and the motor's position or speed"
        )
        say(f"\nAbove the sensors' noise{of}: {names}; {why}.")
        return
    console.print(_where(found, f"\nWhere the model fails{of}"))
    for signal in dict.fromkeys(d.signal for d in found):
        say(next(d for d in found if d.signal == signal).sentence())


def _where(found: Sequence[Dependence], title: str) -> ReportTable:
    from ..comparison.where import WEAK

    table = ReportTable(title)
    table.words("error of", "against")
    table.numbers("share of power")
    table.numbers("RMSE, low → high", justify="left")
    table.words("largest")
    if not is_narrow():  # the sentences below say it too
        table.numbers("RMSE there", "elsewhere")
    for signal in dict.fromkeys(d.signal for d in found):
        best, *others = (d for d in found if d.signal == signal)
        name = signal.replace("_", " ")
        for d in (best, *(d for d in others if d.share >= WEAK)):
            sizes = (quantity(d.rmse_there, d.unit), quantity(d.rmse_elsewhere, d.unit))
            table.add_row(
                name, d.variable.replace("_", " "), f"{100.0 * d.share:.0f} %",
                sparkline(d.profile), d.place, *(() if is_narrow() else sizes),
            )  # fmt: skip
            name = ""
        table.add_section()
    return table

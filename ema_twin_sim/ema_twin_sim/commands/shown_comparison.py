"""Print a comparison on the terminal: each model's errors next to the sensors' noise, and where it fails."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from rich.markup import escape

from ..comparison.beyond_noise import beyond_noise, shown_signals
from ..comparison.compare import Comparison
from ..comparison.where import FEWEST_SAMPLES, Dependence
from ..criteria import SMALL
from ..listing import few_of, listed
from ..quantities import quantity, signal_words
from ..simulation.compared_signals import ENCODER_DIFFERENCE
from ..simulation.encoder_difference import too_long
from ..words.at_rest import at_rest_sentence
from ..words.decisive import decisive_sentence
from ..words.error_cells import ALL, error_cell, noise_cell
from ..words.sentences import by_number, input_words
from ..words.setpoint_shift import shift_sentence, shift_words
from .output import console, say, sparkline
from .side_by_side import show_side_by_side
from .tables import ReportTable, is_narrow
from .torque_errors import show_torque_errors

BLIND = 0.5  # noise as a fraction of the signal; above it, an error within the noise says nothing


def show_comparison(comparisons: Sequence[Comparison], labels: Sequence[str] = (), start: float = 0.0) -> None:
    """Print the errors of all models, then where each fails; ``labels`` distinguish models of the same name.

    ``start`` [s] is where the recordings were cut.
    """
    names = [comparison.model for comparison in comparisons]
    if labels and len(set(names)) < len(names):
        comparisons = [replace(c, model=label) for c, label in zip(comparisons, labels, strict=True)]
    if len(comparisons) > 1:
        show_side_by_side(comparisons)
    else:
        _show_errors(comparisons[0])
    if comparisons[0].input == "current":
        driving = input_words("current", comparisons[0].overall, comparisons[0].motion)
        say(f"The {driving} drives the twin open loop: its speed and positions drift and are left out (JSON has them).")
        if ENCODER_DIFFERENCE in comparisons[0].overall:
            say("The encoder difference of a model is that of its output driven by the motor's measured motion.")
        long = [r.name for r in comparisons[0].recordings if too_long(r.samples) and "output_position" in r.signals]
        if long:
            say(f"Recordings too long for an encoder difference: {few_of(long)}.")
    for comparison in comparisons:
        torques = {r.name: r.torque_error for r in comparison.recordings if r.torque_error is not None}
        show_torque_errors(torques, comparison.motion, comparison.model if len(comparisons) > 1 else "")
    for comparison in comparisons:
        _show_where(comparison, titled=len(comparisons) > 1)
    _show_shifts(comparisons)
    for comparison in comparisons:
        for sentence in filter(None, (decisive_sentence(comparison, start), at_rest_sentence(comparison))):
            of = f" ({comparison.model})" if len(comparisons) > 1 else ""
            say(f"\nNote{of}: {sentence}.")


def _show_shifts(comparisons: Sequence[Comparison]) -> None:
    """Print what a position error in proportion to the speed most likely is; in full for the first model with one."""
    told = False
    for comparison in comparisons:
        said = shift_sentence(comparison)
        if said and comparison.shift is not None:
            of = f" ({comparison.model})" if len(comparisons) > 1 else ""
            short = f"likewise the machine is {shift_words(comparison.shift)} than the twin."
            say(f"Note{of}: {short}" if told else f"\nNote{of}: {said[:1].lower()}{said[1:]}")
            told = True


def _show_errors(comparison: Comparison) -> None:
    """Print one model's errors: one row per recording or, on a narrow terminal, one table per recording."""
    names = shown_signals(comparison.input, comparison.overall)
    rows = [(r.name, r.signals) for r in sorted(comparison.recordings, key=lambda r: by_number(r.name))]
    rows.append((ALL, comparison.overall))
    title = f"RMSE, measured minus twin (input: {input_words(comparison.input, comparison.overall, comparison.motion)})"
    table = ReportTable(title)
    table.words("recording")
    table.numbers(*(signal_words(name, comparison.overall[name]["unit"]) for name in names))
    errors = [comparison.overall[name] for name in names]
    table.add_row("noise floor of the sensors", *(noise_cell(error) for error in errors), style="dim")
    table.add_section()
    for name, signals in rows:
        if name == ALL:
            table.add_section()
        table.add_row(name, *(error_cell(signals.get(n)) for n in names), style="bold" if name == ALL else None)
    if table.fits():
        console.print(table)
        return
    say(title, style="table.title")
    for name, signals in rows:
        say(name, style="bold")
        table = ReportTable()
        table.words("signal")
        table.numbers("noise floor", escape(comparison.model), least=len("99.7 mrad/s"))
        for n in names:
            words = signal_words(n, comparison.overall[n]["unit"])
            table.add_row(words, noise_cell(signals.get(n)), error_cell(signals.get(n)))
        console.print(table)


def _show_where(comparison: Comparison, *, titled: bool) -> None:
    of = f" ({comparison.model})" if titled else ""
    overall = comparison.overall
    shown = shown_signals(comparison.input, overall)
    poor = beyond_noise(comparison.input, overall)
    found = [d for d in comparison.where if d.signal in poor]
    few = sum(recording.samples for recording in comparison.recordings) < FEWEST_SAMPLES
    if not poor and few:
        short = f"the recordings are too short to be sure ({FEWEST_SAMPLES} samples are needed)"
        say(f"\nNo error exceeds the sensors' noise{of}, but {short}.")
        return
    if not poor:
        say(f"\nAll errors are at the sensors' noise floor{of}{_what_that_says(comparison, shown)}.")
        return
    if not found:
        names = ", ".join(sorted(signal_words(name, overall[name]["unit"]) for name in poor))
        traced = dict.fromkeys(d.signal for d in comparison.where)
        if few:
            why = f"the recordings are too short to locate the error ({FEWEST_SAMPLES} samples are needed)"
        elif traced:
            of_these = listed(signal_words(name, overall[name]["unit"]) for name in traced)
            why = f"the location is analysed for {of_these} only"
        else:
            why = "to locate the error, the current and the motor's position or speed are needed"
        say(f"\nAbove the sensors' noise{of}: {names}; {why}.")
        return
    console.print(_where(found, f"\nWhere the model fails{of}"))
    for signal in dict.fromkeys(d.signal for d in found):
        say(next(d for d in found if d.signal == signal).sentence())


def _what_that_says(comparison: Comparison, shown: Sequence[str]) -> str:
    """End of the sentence on errors within the noise; warns if noise is more than half of a signal."""
    overall = comparison.overall
    errors = {name: overall[name] for name in shown if overall[name]["rmse"] and not overall[name]["driven"]}
    noise = {name: error["relative"] * error["noise_floor"] / error["rmse"] for name, error in errors.items()}
    blind = [
        f"that of the {signal_words(name, overall[name]['unit'])} is {100.0 * share:.0f} % of the signal"
        for name, share in noise.items()
        if share > BLIND
    ]
    if not blind:
        errors_of_torque = (recording.torque_error for recording in comparison.recordings)
        left = max((e.filtered for e in errors_of_torque if e is not None and e.is_filtered), default=0.0)
        if left > SMALL:
            what = "force" if comparison.motion == "linear" else "torque"
            share = f"{100.0 * left:.0f} % of the {what}"
            return f", but up to {share} remains where it changes slowly: run discover to find out why"
        return "; run discover to look for smaller missing effects"
    large = " and ".join(blind)
    return f", but {large}, which hides any error; check the sensors' constants in the model's file"


def _where(found: Sequence[Dependence], title: str) -> ReportTable:
    table = ReportTable(title)
    table.words("error of", "against")
    table.numbers("share of power")
    table.numbers("RMSE, low → high", justify="left")
    table.words("where it is largest")
    if not is_narrow():  # the sentences below say it too
        table.numbers("RMSE there", "elsewhere")
    for signal in dict.fromkeys(d.signal for d in found):
        best, *others = (d for d in found if d.signal == signal)
        name = signal_words(signal, best.unit)
        for d in (best, *(d for d in others if d.share >= SMALL)):
            sizes = ("–", "–")
            if d.is_largest_there:
                sizes = (quantity(d.rmse_there, d.unit), quantity(d.rmse_elsewhere, d.unit))
            table.add_row(
                name, d.variable.replace("_", " "), f"{100.0 * d.share:.0f} %",
                sparkline(d.profile), d.where, *(() if is_narrow() else sizes),
            )  # fmt: skip
            name = ""
        table.add_section()
    return table

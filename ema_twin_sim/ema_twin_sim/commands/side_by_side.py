"""Models side by side, as table 5.1 of the thesis: one row per recording, one column per model, and times closer."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from rich.markup import escape

from ..comparison.beyond_noise import shown_signals
from ..comparison.closeness import Closeness, CloserModel, closer
from ..comparison.compare import Comparison
from ..comparison.running_comparison import SignalError
from ..criteria import CLEARLY_MORE
from ..listing import listed
from ..quantities import quantity, signal_words
from ..words.error_cells import ALL, closeness_cell, error_cell, noise_cell, number_of_times
from ..words.sentences import by_number, input_words
from .output import console, say
from .tables import ReportTable

_POSITIONS = ("output_position", "motor_position")
_CLOSER = "times closer"
_Table = Callable[[str, Sequence[Comparison]], ReportTable]


def show_side_by_side(comparisons: Sequence[Comparison]) -> None:
    """Print tables of the main signal and of a position, one row per recording; then one of all signals overall."""
    first = comparisons[0]
    names = shown_signals(first.input, first.overall)
    if len(first.recordings) > 1:
        for name in [*names[:1], *[name for name in _POSITIONS if name in names[1:]][:1]]:
            _print_folded(name, comparisons, _of_recordings)
    _print_folded("", comparisons, _of_signals)
    for other in comparisons[1:]:
        say(_in_words(names[0], first, other), style="bold")
    say(
        f"{_CLOSER.capitalize()}: error of {first.model} over that of the other model, each with the noise subtracted "
        "(√(RMSE² − noise floor²)); ≥ if the other model's error is within the noise."
    )


def _print_folded(name: str, comparisons: Sequence[Comparison], table_of: _Table) -> None:
    """Print one table of all models; if the terminal is too narrow, one of the first model with each other model."""
    table = table_of(name, comparisons)
    if table.fits() or len(comparisons) == 2:
        console.print(table)
        return
    for other in comparisons[1:]:
        console.print(table_of(name, [comparisons[0], other]))


def _of_recordings(name: str, comparisons: Sequence[Comparison]) -> ReportTable:
    first = comparisons[0]
    error = first.overall[name]
    driving = input_words(first.input, first.overall, first.motion)
    noise = f"noise floor {quantity(error['noise_floor'], error['unit'])}"
    table = _table(
        f"RMSE of the {signal_words(name, error['unit'])} (input {driving}, {noise})", "recording", comparisons
    )
    closest = [closer(first, other) for other in comparisons[1:]]
    for row in sorted(range(len(first.recordings)), key=lambda k: by_number(first.recordings[k].name)):
        errors = [comparison.recordings[row].signals for comparison in comparisons]
        table.add_row(
            escape(first.recordings[row].name), *_cells(name, errors, [c.recordings[row][1] for c in closest])
        )
    table.add_section()
    errors = [comparison.overall for comparison in comparisons]
    table.add_row(ALL, *_cells(name, errors, [c.overall for c in closest]), style="bold")
    return table


def _of_signals(_: str, comparisons: Sequence[Comparison]) -> ReportTable:
    first = comparisons[0]
    driving = input_words(first.input, first.overall, first.motion)
    of = ALL if len(first.recordings) > 1 else first.recordings[0].name
    table = _table(f"RMSE of {of}, measured minus twin (input {driving})", "signal", comparisons, "noise floor")
    closest = [closer(first, other).overall for other in comparisons[1:]]
    for name in shown_signals(first.input, first.overall):
        errors = [comparison.overall for comparison in comparisons]
        words = signal_words(name, first.overall[name]["unit"])
        table.add_row(words, noise_cell(first.overall[name]), *_cells(name, errors, closest))
    return table


def _table(title: str, rows: str, comparisons: Sequence[Comparison], *before: str) -> ReportTable:
    table = ReportTable(f"\n{title}")
    table.words(rows)
    first, *others = comparisons
    closer = [column for other in others for column in (escape(other.model), _CLOSER)]
    table.numbers(*before, escape(first.model), *closer)
    return table


def _cells(
    name: str, errors: Sequence[Mapping[str, SignalError]], closest: Sequence[Mapping[str, Closeness]]
) -> list[str]:
    """The RMSE of the first model, then that of each other model with how many times closer it is."""
    first, *others = (error_cell(error.get(name)) for error in errors)
    pairs = zip(others, closest, strict=True)
    return [first, *(cell for other, close in pairs for cell in (other, closeness_cell(close.get(name))))]


def _in_words(name: str, first: Comparison, other: Comparison) -> str:
    """``Model better: 14.6 × closer than polito_bench in the current, from 11.2 × (ramp_0.1) to 15.1 × (sine).``"""
    found = closer(first, other)
    signal = signal_words(name, first.overall[name]["unit"])
    if name not in found.overall:
        return f"Model {other.model}: its {signal} is at the sensors' noise, as is that of {first.model}."
    overall = found.overall[name]
    besides = "" if overall.times > CLEARLY_MORE else _closer_elsewhere(first, found, name)
    if overall.times < 1.0:
        times = number_of_times(1.0 / overall.times)
        if times == number_of_times(1.0):
            return f"Model {other.model}: as far off as {first.model} in the {signal}{besides}."
        return f"Model {other.model}: {times} × farther off than {first.model} in the {signal}{besides}."
    text = f"Model {other.model}: {closeness_cell(overall)} closer than {first.model} in the {signal}"
    each = sorted((signals[name].times, recording) for recording, signals in found.recordings if name in signals)
    if len(each) > 1:
        at = dict(found.recordings)
        least, most = (closeness_cell(at[recording][name]) for _, recording in (each[0], each[-1]))
        if least != most:
            text += f", from {least} ({each[0][1]}) to {most} ({each[-1][1]})"
    return f"{text}{besides}{_farther(first, found)}."


def _closer_elsewhere(first: Comparison, found: CloserModel, name: str) -> str:
    """``; ≥ 92 × closer in the encoder difference``: the signals other than ``name`` in which a model is."""
    others = {signal: found.overall.get(signal) for signal in shown_signals(first.input, first.overall)}
    return "".join(
        f"; {closeness_cell(closeness)} closer in the {signal.replace('_', ' ')}"
        for signal, closeness in others.items()
        if signal != name and closeness is not None and closeness.times > CLEARLY_MORE
    )


def _farther(first: Comparison, found: CloserModel) -> str:
    """``; 1.3 × farther off in the speed``: the signals in which a model that is closer in the main one is not."""
    by_times: dict[str, list[str]] = {}
    for signal in shown_signals(first.input, first.overall):
        closeness = found.overall.get(signal)
        if closeness is not None and closeness.times < 1.0:
            times = number_of_times(1.0 / closeness.times)
            by_times.setdefault(times, []).append(f"the {signal.replace('_', ' ')}")
    by_times.pop(number_of_times(1.0), None)
    return "".join(f"; {times} × farther off in {listed(signals)}" for times, signals in by_times.items())

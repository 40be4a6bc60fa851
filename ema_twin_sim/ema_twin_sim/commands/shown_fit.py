"""Print a fit on the terminal: its parameters with standard errors, the errors that remain, and its warnings."""

from __future__ import annotations

from collections.abc import Sequence

from ..fitting.doubts import tells
from ..fitting.findings import Finding
from ..fitting.fit import FitResult
from ..model import Model
from ..quantities import estimate, quantity, signal_words
from ..words.parameters import numbers_of, parameter_rows
from ..words.sentences import change_words
from .output import console, say, warn
from .tables import ReportTable
from .torque_errors import show_torque_errors

KINDS = {
    "on_bound": "On a bound",
    "no_effect": "Not identifiable",
    "inseparable": "Inseparable",
    "absurd": "Implausible",
}
"""The kinds of warnings, as headings."""


def show_fit(found: FitResult, before: Model) -> None:
    """Print the fitted numbers next to those of the model ``before``, the errors, and the notes and warnings."""
    if found.parameters:
        console.print(_parameters(found, before))
    if found.constants:
        console.print(_constants(found))
    console.print(errors_table(found))
    show_torque_errors(found.torque_errors, found.model.motion)
    for note in found.notes:
        say(f"Note: {note}.")
    _warn(found.warnings)


def _parameters(found: FitResult, before: Model) -> ReportTable:
    table = ReportTable(f"Parameters, with standard errors (method {found.method})")
    table.words("effect", "options", "parameter")
    table.numbers("before", "fitted", justify="left")
    for name, entry in found.parameters.items():
        for first, parameter, held in parameter_rows(name, entry["options"], numbers_of(entry)):
            old = estimate(before.effects[name].parameters[parameter], None, held["unit"])
            new = "fixed" if held["std"] is None else estimate(held["value"], held["std"], held["unit"])
            table.add_row(*first, parameter.replace("_", " "), old, new)
    return table


def _constants(found: FitResult) -> ReportTable:
    table = ReportTable("\nConstants, within their tolerances")
    table.words("part", "constant")
    table.numbers("before", "fitted", justify="left")
    table.numbers("change")
    for part, entries in found.constants.items():
        for name, held in entries.items():
            before, fitted, change = estimate(held["nominal"], None, held["unit"]), "not identifiable", ""
            if held["std"] is not None:
                fitted = estimate(held["value"], held["std"], held["unit"])
                change = change_words(held)
            table.add_row(part, name.replace("_", " "), before, fitted, change)
    return table


def errors_table(found: FitResult) -> ReportTable:
    """Table of the errors before and after, on data that was not fitted to; without those of signals that drift."""
    table = ReportTable(f"\nErrors: {found.judged_on}")
    table.words("signal")
    table.numbers("RMSE before", "after", "noise floor")
    for signal, error in found.before.items():
        if tells(signal, error, found.before):
            numbers = (error["rmse"], found.after[signal]["rmse"], error["noise_floor"])
            table.add_row(signal_words(signal, error["unit"]), *(quantity(number, error["unit"]) for number in numbers))
    return table


def _warn(warnings: Sequence[Finding]) -> None:
    """Print one line per warning, equal ones once; damaged recordings were reported when they were read."""
    for kind, message in dict.fromkeys((w.kind, w.message) for w in warnings if w.kind in KINDS):
        warn(f"{KINDS[kind].lower()}: {message}")

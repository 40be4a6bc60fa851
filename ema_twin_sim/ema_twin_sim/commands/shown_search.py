"""Print a search on the terminal: its verdict, its steps, the parameters, and what stays in doubt."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import compress
from typing import Any

from rich.markup import escape

from ..discovery.discover import Discovery, Step
from ..effects import catalogue
from ..measured.folds import HALF_OF
from ..model.constants import PARTS
from ..quantities import estimate, quantity, signal_words
from ..words.dropped import less_dropped
from ..words.next_recording import recording_words
from ..words.parameters import numbers_of, parameter_rows
from ..words.sentences import (
    REFIT,
    REFIT_IS,
    change_words,
    draft_words,
    effect_words,
    groups_sentence,
    has_moved,
    is_visible,
    larger_sentence,
    left_sentence,
    order_sentences,
    output_sentence,
    refit_sentence,
    removed_words,
    verdict_of,
    why_step,
)
from .output import console, say
from .tables import ReportTable, is_narrow

STEPS_ARE = (
    "Excess: mean square of the error minus that of the sensors' noise; removing 99 % of it leaves a tenth of the RMSE."
    " Runner-up: the second-best effect of the step, and its gain relative to the step's."
)
"""Explains the columns of the table of steps."""


def show_search(found: Discovery, without: Sequence[str] = ()) -> None:
    """Print the verdict in one sentence, the steps that led there, and the numbers."""
    say(verdict_of(found, without=without), style="bold")
    if found.verdict == "unknown":
        left = found.unseen
        say(
            f"Remaining error: {quantity(left.rmse[-1], left.unit)} of the {signal_words(left.signal, left.unit)}; "
            f"the sensors' noise is {quantity(left.noise_floor, left.unit)}"
            + (", which hides it in single samples, but not in many." if left.rmse[-1] < left.noise_floor else ".")
        )
    if found.unseen.refitted and not found.steps:
        say(refit_sentence(found.unseen))
    if found.steps:
        shown, dropped = less_dropped(found.steps)
        if shown or found.unseen.refitted:
            console.print(_steps(found, shown))
            say(STEPS_ARE)
        for told in filter(None, (dropped, larger_sentence(shown, found.unseen), left_sentence(found.unseen))):
            say(told)
        if _is_crowded(found):
            for step in shown:
                what = "Runner-up to" if step.action == "add" else "Dropped:"
                say(f"{what} {effect_words(step.instance)}: {why_step(step)}.")
    if found.parameters:
        console.print(_parameters(found))
    for sentence in order_sentences(found.model, found.parameters):
        say(sentence)
    moved = _constants(found)
    if moved.row_count:
        console.print(moved)
    if told := output_sentence(found.model, _shown_names(found)):
        say(told)
    slightly, unknown = moved_slightly(found)
    if slightly:
        say(f"\n{'Also refitted' if moved.row_count else 'Refitted'}, within standard errors: {', '.join(slightly)}.")
    if unknown:
        say(f"\nNot known from these recordings (the error is larger than the value): {', '.join(unknown)}.")


def show_doubts(groups: Sequence[Sequence[str]], next_recording: str, motion: str) -> None:
    """Print what the recordings cannot tell apart, and the recording to make next of a machine of this ``motion``."""
    if groups:
        say(f"\n{groups_sentence(groups)}")
    if next_recording:
        say(f"\nRecord next: {recording_words(next_recording, motion)}")


def _steps(found: Discovery, shown_steps: Sequence[Step]) -> ReportTable:
    several = len(found.unseen.recordings) > 1
    judged_on = f"recordings {'not ' if several else ''}used for fitting"
    if HALF_OF in found.recordings[0].metadata:
        judged_on = "the half of the points not used for fitting"
    unseen = found.unseen
    floor = quantity(unseen.noise_floor, unseen.unit)
    signal = signal_words(unseen.signal, unseen.unit)
    table = ReportTable(f"\nSteps, judged by the {signal} of {judged_on} (noise floor {floor})")
    narrow, output, crowded = is_narrow(), _has_output(found), _is_crowded(found)
    table.words("step", *(() if narrow else ("what it is",)), widest=44)
    shown = "encoder difference" if unseen.encoders else "output position"
    table.numbers("RMSE before", "after", "excess removed", *((f"{shown} before", "after") if output else ()))
    table.words(*(() if crowded else ("runner-up",)))
    has_room = (True, not narrow, True, True, True, output, output, not crowded)
    if unseen.refitted:
        outputs = (unseen.given_output, unseen.output[0]) if output and unseen.given_output is not None else ()
        sizes = draft_words(unseen.given, unseen.rmse[0], unseen.unit), quantity(unseen.rmse[0], unseen.unit)
        removed = removed_words(unseen.refit_removed, unseen.given, unseen.rmse[0])
        cells = (REFIT, REFIT_IS, *sizes, removed, *(quantity(value, "rad") for value in outputs))
        table.add_row(*compress(cells, has_room))
        table.add_section()
    for step in shown_steps:
        name, why = effect_words(step.instance), escape(why_step(step))
        cells = (f"− {name}", why, *[""] * 5, why if narrow else "")
        if step.action == "add":  # what was dropped has its numbers in the row of the effect that made it needless
            sizes = quantity(step.rmse_before, step.unit), quantity(step.rmse_after, step.unit)
            removed = removed_words(step.error_removed, step.rmse_before, step.rmse_after)
            positions = (quantity(value, "rad") for value in (step.output_before, step.output_after))
            cells = (f"+ {name}", escape(catalogue()[step.effect].summary), *sizes, removed, *positions, why)
        table.add_row(*compress(cells, has_room))
    return table


def _has_output(found: Discovery) -> bool:
    """Whether the steps also have errors of the output's position."""
    return any(step.output_before is not None for step in found.steps)


def _is_crowded(found: Discovery) -> bool:
    """Whether the table of steps has no room for words."""
    return is_narrow() and _has_output(found)


def _parameters(found: Discovery) -> ReportTable:
    table = ReportTable("\nParameters, with standard errors")
    table.words("effect", "options", "parameter")
    table.numbers("value", justify="left")
    for name, entry in found.parameters.items():
        for first, parameter, held in parameter_rows(name, entry["options"], numbers_of(entry)):
            fitted = "" if held["std"] is not None else " (typical value, not fitted)"
            table.add_row(*first, parameter, f"{estimate(held['value'], held['std'], held['unit'])}{fitted}")
    return table


def _shown_names(found: Discovery) -> list[str]:
    """What the tables of parameters and of constants have rows of: effects, and parts of the machine."""
    constants: Mapping[str, Mapping[str, Any]] = found.constants
    moved = (part for part, entries in constants.items() if any(map(has_moved, entries.values())))
    return [*found.parameters, *moved]


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


def moved_slightly(found: Discovery) -> tuple[list[str], list[str]]:
    """The constants that moved by less than their standard error: ``motor inertia +0.4 %``.

    Second, those of them whose error is larger than their value, which no change describes: ``inertia = 0 ± 3 g m^2``.
    """
    moved, unknown = [], []
    constants: Mapping[str, Mapping[str, Any]] = found.constants
    for part, entries in constants.items():
        for name, held in entries.items():
            distance, std = abs(held["value"] - held["nominal"]), held["std"] or 0.0
            if held["nominal"] and is_visible(held["nominal"], held["value"]) and distance <= std:
                named = name.replace("_", " ") if part in PARTS else effect_words(part)
                if std < abs(held["value"]):
                    moved.append(f"{named} {change_words(held)}")
                else:
                    unknown.append(f"{named} = {estimate(held['value'], std, held['unit'])}")
    return moved, unknown

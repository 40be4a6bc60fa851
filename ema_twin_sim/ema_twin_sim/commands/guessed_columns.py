"""What the columns of a trace are, as ``ema-twin init`` takes them, and what is said of those that it does not use."""

from __future__ import annotations

from pathlib import Path
from shlex import quote

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.load import load
from ema_bench_replay.some_of import some_of
from ema_bench_replay.traces.header_words import header_words
from ema_bench_replay.traces.run_columns import count_of_runs, how_to_read_runs, run_columns
from ema_bench_replay.traces.trace_table import read_table

from ..new_machine.columns import Guess, Guesses, guess_columns
from ..new_machine.given import Given
from ..new_machine.interleaved_rows import refuse_interleaved_rows
from ..new_machine.lengths import at_the_slide, how_to_use_length
from ..new_machine.rows import with_kind_of_rows
from ..new_machine.rows_at_ends import with_rows_of_others
from ..new_machine.same_names import refuse_same_names
from ..new_machine.sign_bits import how_to_decode
from ..new_machine.turns import counted_on_turns
from ..new_machine.units_by_numbers import with_units
from ..new_machine.unused_columns import that_may_be_commands, that_may_be_motion, that_may_be_the_drives
from .output import say
from .shown_draft import ask_for_drive, ask_for_motion, say_unclear, say_unused


def guessed_columns(trace: Path, given: Given, of_points: bool) -> tuple[Guesses, tuple[Guess, ...]]:
    """Guess what the columns of a trace are; second, what the columns are that some cells without a number exclude.

    Rows are operating points if ``of_points`` says so, or if they look like it. Raises InputError if no column is
    recognised.
    """
    table = read_table(trace, needed=lambda header: ())
    if table.is_cut:
        table = with_rows_of_others(table, slides=given.travel_per_turn is not None)
    columns = some_of(filter(None, table.header))
    numbers = table.numbers
    no_numbers = {
        name: int(np.count_nonzero(np.isnan(column))) for name, column in numbers.items() if np.isnan(column).any()
    }
    slides = given.travel_per_turn is not None
    try:
        guesses = guess_columns(table.header, frozenset(no_numbers), numbers, slides=slides)
    except InputError as error:
        raise InputError(f"{trace}: {error}") from None
    guesses = at_the_slide(guesses.timed_in_seconds(table.in_seconds), given.travel_per_turn, numbers)
    try:
        guesses = with_kind_of_rows(guesses, numbers, of_points)
    except InputError as error:
        raise InputError(f"{trace}: header: no time column among {columns}; {error}") from None
    refuse_same_names(table, guesses)
    refuse_interleaved_rows(table, guesses, numbers)
    guesses = with_units(*counted_on_turns(guesses, numbers), given.gear_ratio)
    rows = len(table.columns[0])
    empty = frozenset(name for name, count in no_numbers.items() if count == rows)
    holed = tuple(
        guess for guess in guess_columns(table.header, empty, slides=slides).signals if guess.column in no_numbers
    )
    for name, count in no_numbers.items():
        if not name and count == rows:
            continue  # the empty column that a delimiter at the end of each line makes
        first = table.line(int(np.flatnonzero(np.isnan(numbers[name]))[0]))
        where = f" (the first in line {first})" if count < rows else ""
        said = f"{name or 'a column without a name'}: {count} of {rows} cells hold no number{where}, so it is not used"
        if any(guess.column == name for guess in holed):
            said += "; to use it, fill in these cells or remove their rows, and run init again"
        say(said)
    for name in guesses.other_motion:
        unit, other = header_words(name).unit, "linear" if guesses.motion == "rotary" else "rotary"
        say(
            f"{name}: {unit} is a unit of a {other} machine, and by the other columns this one is {guesses.motion}, so "
            f"it is not used ({how_to_use_length(name, guesses)}if the unit is wrong, correct the header and run init "
            "again)"
        )
    for name in guesses.row_counters:
        say(f"{name}: not used, since it rises by the same step in every row, as the number of a row does")
    for name in guesses.clock_counters:
        say(
            f"{name}: not used, since it counts at a constant rate, as a clock does (if it counts a shaft's turns, say "
            "so in its name, as in 'motor position [counts]', and run init again)"
        )
    for sentence in how_to_decode(guesses.sign_bits):
        say(sentence)
    for name, why in guesses.lost_commands.items():
        say(
            f"{name}: not used, since {why} (if it commands the output's position, add its unit to the name, as in "
            f"'{name} [deg]', and run init again)"
        )
    for name, difference in guesses.control_errors.items():
        say(f"{name}: not used, since it is {difference}: a control error")
    for name, copied in guesses.repeats.items():
        say(f"{name}: not used, since it {copied}")
    if angles := guesses.phase_angles:
        say(
            f"{some_of(angles)}: not used, since power analysers give the angle between voltage and current so (if "
            "one is a shaft's, say so in its name, as in 'motor position [deg]', and run init again)"
        )
    taken = next((guess.column for guess in guesses.signals if guess.signal == "motor_position"), "")
    for name in guesses.other_axes:
        say(
            f"{name}: not used, since {taken} goes with the speed more (if it is the motor's, say so in its name, as "
            "in 'motor position', and run init again)"
        )
    runs = run_columns(guesses.left)
    unused = [name for name in guesses.left if name and name not in {*no_numbers, *runs}]
    say_unused(guesses, unused)
    unread = that_may_be_motion(guesses, unused, numbers)
    if guesses.signals and unread:
        ask_for_motion(unread)
    elif unclear := that_may_be_commands(guesses, unused, numbers):
        say_unclear(unclear, guesses.motion)
    if guesses.signals and not unread and (unread := that_may_be_the_drives(guesses, unused, numbers)):
        ask_for_drive(unread)
    for name in runs:
        count = count_of_runs(numbers[name])
        if count > 1:
            say(f"{name}: seems to number {count} runs; {how_to_read_runs(name)}")
            break
    if not guesses.signals:
        if _is_of_a_siemens_drive(trace):
            raise InputError(
                f"{trace}: is a Siemens drive's trace, which needs no map; leave init out: "
                f"ema-twin info {quote(str(trace))}"
            )
        if empty_signals := [guess.column for guess in guess_columns(table.header).signals if guess.column in empty]:
            raise InputError(
                f"{trace}: {some_of(empty_signals)}: no cell holds one number by itself (lists hold several); "
                "write a column for each number, as in 'motor position [rad]', and run init again"
            )
        if holed:
            raise InputError(
                f"{trace}: {some_of(guess.column for guess in holed)}: without these nothing is left to read; "
                "fill in the cells that hold no number, or remove their rows, and run init again"
            )
        raise InputError(
            f"{trace}: header: no column recognised among {columns}; rename them, as in "
            "'time [s]', 'current [A]', 'motor position [rad]'"
        )
    return guesses, holed


def _is_of_a_siemens_drive(trace: Path) -> bool:
    try:
        load(trace)
    except InputError:
        return False
    return True

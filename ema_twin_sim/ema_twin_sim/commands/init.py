"""``ema-twin init``: a first import map and a first model of a new machine."""

from __future__ import annotations

from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated

import typer

from ema_bench_replay.errors import InputError
from ema_bench_replay.outputs import write_text

from ..listing import by_recording
from . import options
from .asked_machine import GEAR_RATIO, TORQUE_CONSTANT, asked
from .output import say, warn
from .shown_draft import (
    ask_for_drive,
    ask_for_motion,
    in_unit,
    say_next,
    say_search,
    say_unclear,
    say_unused,
    say_what_it_rests_on,
    say_what_to_look_at,
    warn_of_contradicted_names,
    warn_of_foreign_units,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..new_machine.columns import Guess, Guesses
    from ..new_machine.given import Given

EXAMPLES = """Examples:

ema-twin init trace.csv -o press

ema-twin init trace_*.csv -o press --gear-ratio 50 --torque-constant 0.8

ema-twin init slide.csv -o slide --torque-constant 0.043 --travel-per-turn '5 mm'      (positions in mm, by a screw)

ema-twin init trace.csv -o press --map my_map.yaml      (the model only)

ema-twin init friction_curve.csv -o press --operating-points      (each row is steady)

ema-twin init -o press      (asks which columns your traces have)"""


def run(
    output: Annotated[
        str,
        typer.Option(
            "-o", "--output", metavar="NAME", help="Writes NAME_map.yaml and NAME.yaml; may include a folder."
        ),
    ],
    traces: Annotated[
        list[Path] | None,
        typer.Argument(metavar="[TRACE]…", help="CSVs of the machine; without them, questions are asked."),
    ] = None,
    gear_ratio: Annotated[
        float | None,
        typer.Option(
            metavar="RATIO",
            parser=GEAR_RATIO,
            help="Turns of the motor per turn of the output.",
        ),
    ] = None,
    torque_constant: Annotated[
        float | None,
        typer.Option(
            metavar="N_M_PER_A",
            parser=TORQUE_CONSTANT,
            help="Torque per ampere, from the motor's data sheet; of a linear motor its force in N.",
        ),
    ] = None,
    travel_per_turn: Annotated[
        float | None,
        typer.Option(
            metavar="LENGTH",
            parser=options.length,
            help="Way of a slide per turn of its motor, as in '5 mm': the lead of a screw, the circumference of a "
            "belt's pulley or a rack's pinion, divided by the gear ratio. The torque constant is then in N m/A.",
        ),
    ] = None,
    import_map: Annotated[
        str | None,
        typer.Option(
            "--map",
            metavar="MAP",
            help="An existing import map; only the model is written.",
            autocompletion=options.map_names,
        ),
    ] = None,
    operating_points: Annotated[
        bool,
        typer.Option("--operating-points", help="Each row is an operating point: at rest, or at constant speed."),
    ] = False,
    force: options.Force = False,
) -> None:
    """Draft an import map and a model of a new machine from its recordings.

    Columns are recognised by their names and units. Missing units, the gear ratio, the encoders' counts and the drive's
    gains are estimated from the data. What could not be determined is marked CHECK in both files: check these lines
    before you trust a result.
    """
    from ema_bench_replay.configuration import find_configuration

    from ..model.model_file import check_model_name
    from ..new_machine.drafts import checked_drafts
    from ..new_machine.given import Given
    from ..new_machine.lengths import told_of_turns
    from ..new_machine.other_traces import differing_columns
    from ..new_machine.told import assumed_units

    place = Path(output)
    if place.suffix.lower() in (".yaml", ".yml"):  # a model's file name, which other commands take
        place = place.with_suffix("")
    files = place.with_name(f"{place.name}_map.yaml"), place.with_name(f"{place.name}.yaml")
    check_model_name(files[1])
    for path in files if import_map is None else files[1:]:
        if path.exists() and not force:
            raise InputError(f"{path}: exists already; give another name with -o, or --force to replace it")
    given = Given(place.name, gear_ratio, torque_constant, travel_per_turn=travel_per_turn)
    traces = traces or []
    if import_map is not None:
        _model_alone(traces, given, find_configuration("maps", import_map), files[1], force)
        return
    holed: tuple[Guess, ...] = ()
    if not traces:
        guesses, given = asked(given)
    else:
        guesses, holed = _guessed(traces[0], given, operating_points)
        warn_of_contradicted_names(guesses)
        for sentence in differing_columns(traces[0], guesses, traces[1:], slides=travel_per_turn is not None):
            warn(sentence)
    drafts = checked_drafts(guesses, given, traces)
    for path, text in zip(files, (drafts.map, drafts.model), strict=True):
        write_text(path, text, force=force)
    guesses = guesses.with_load(drafts.load) if drafts.load is not None else guesses
    guesses = guesses.without(tuple(drafts.left_out)).changed(drafts.magnitudes, magnitude=True)
    rests_on = ""
    if traces:
        for guess in guesses.signals:
            say(f"{guess.column} → {guess.signal}{in_unit(guess)}{', a command' if guess.command else ''}")
        for column, reason in drafts.left_out.items():
            say(f"{column}: {reason}")
        warn_of_foreign_units(guesses)
        joint = (guesses.joint.sentence,) if guesses.joint.name else ()
        known = (*drafts.known, *told_of_turns(guesses, travel_per_turn))
        rests_on = say_what_it_rests_on(*files, (*joint, *assumed_units(guesses), *drafts.assumed), known)
        for lacked in drafts.lacked:
            say(lacked)
    for told in by_recording((*drafts.warnings, *drafts.questions)):
        warn(told)
    say_next(files, drafts, guesses, [quote(str(trace)) for trace in traces] or ["TRACE.csv"], holed, rests_on)


def _model_alone(traces: Sequence[Path], given: Given, map_file: Path, place: Path, force: bool) -> None:
    """Write only the model, for recordings that have an import map already."""
    from ema_bench_replay.load import load
    from ema_bench_replay.recording import AT

    from ..new_machine.drafts import checked_model
    from ..new_machine.shaft import Shaft

    if not traces:
        raise InputError("init: --map needs a recording; give one, or leave --map out to answer questions")
    recordings = [load(trace, import_map=map_file) for trace in traces]
    for warning in by_recording(warning for recording in recordings for warning in recording.warnings):
        warn(warning)
    shaft = Shaft(recordings[0].metadata.get(f"motor_position{AT}", "motor"), given.gear_ratio)
    model = checked_model(recordings, given, shaft, str(traces[0]))
    write_text(place, model.text, force=force)
    rests_on = say_what_it_rests_on(map_file, place, model.assumed)
    for lacked in model.lacked:
        say(lacked)
    for question in by_recording(model.questions):
        warn(question)
    say_what_to_look_at(place, model.text, rests_on)
    say("Then:")
    say_search(" ".join(quote(str(trace)) for trace in traces), map_file, place)


def _guessed(trace: Path, given: Given, of_points: bool) -> tuple[Guesses, tuple[Guess, ...]]:
    """Guess what the columns of a trace are; second, what the columns are that some cells without a number exclude.

    Rows are operating points if ``of_points`` says so, or if they look like it. Raises InputError if no column is
    recognised.
    """
    import numpy as np

    from ema_bench_replay.some_of import some_of
    from ema_bench_replay.traces.header_words import header_words
    from ema_bench_replay.traces.run_columns import count_of_runs, how_to_read_runs, run_columns
    from ema_bench_replay.traces.trace_table import read_table

    from ..new_machine.columns import guess_columns
    from ..new_machine.interleaved_rows import refuse_interleaved_rows
    from ..new_machine.lengths import at_the_slide, how_to_use_length
    from ..new_machine.rows import with_kind_of_rows
    from ..new_machine.rows_at_ends import with_rows_of_others
    from ..new_machine.same_names import refuse_same_names
    from ..new_machine.sign_bits import how_to_decode
    from ..new_machine.turns import counted_on_turns
    from ..new_machine.units_by_numbers import with_units
    from ..new_machine.unused_columns import that_may_be_commands, that_may_be_motion, that_may_be_the_drives

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
    from ema_bench_replay.load import load

    try:
        load(trace)
    except InputError:
        return False
    return True

"""``ema-twin init``: a first import map and a first model of a new machine."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated

import typer

from ema_bench_replay.errors import InputError

from . import options
from .output import say, warn

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..new_machine.columns import Guess, Guesses
    from ..new_machine.drafts import Drafts
    from ..new_machine.given import Given

EXAMPLES = """Examples:

ema-twin init trace.csv -o press

ema-twin init trace_*.csv -o press --gear-ratio 50 --torque-constant 0.8

ema-twin init trace.csv -o press --map my_map.yaml      (the model only)

ema-twin init friction_curve.csv -o press --operating-points      (each row is steady)

ema-twin init -o press      (asks which columns your traces have)"""

LEAST_RATIO, MOST_RATIO = 1e-3, 1e5
SHAFTS = "motor", "output"
_QUESTIONS = {
    "time": "Column of the time, with its unit, as in 'time [s]'",
    "current": "Column of the motor's current, as in 'current [A]' (empty: there is none)",
    "motor_torque": "Column of the motor's torque or force, as in 'torque [Nm]' (empty: there is none)",
    "motor_position": "Column of the motor's position, as in 'motor position [rad]'",
    "speed": "Column of the motor's speed, as in 'speed [rpm]' (empty: there is none)",
    "output_position": "Column of the output's position, as in 'output position [deg]' (empty: there is none)",
}


def run(
    output: Annotated[
        str,
        typer.Option("-o", "--output", metavar="NAME", help="Writes NAME_map.yaml and NAME.yaml; may hold a folder."),
    ],
    traces: Annotated[
        list[Path] | None,
        typer.Argument(metavar="[TRACE]…", help="CSVs of the machine; without them, questions are asked."),
    ] = None,
    gear_ratio: Annotated[
        float | None,
        typer.Option(
            metavar="RATIO",
            parser=options.number(LEAST_RATIO, MOST_RATIO, "turns of the motor per turn of the output"),
            help="Turns of the motor per turn of the output.",
        ),
    ] = None,
    torque_constant: Annotated[
        float | None,
        typer.Option(
            metavar="N_M_PER_A",
            parser=options.number(1e-6, options.LARGEST, "N m/A (of a linear machine N/A)"),
            help="Torque (N m, or N) per ampere, from the motor's data sheet.",
        ),
    ] = None,
    import_map: Annotated[
        str | None,
        typer.Option("--map", metavar="MAP", help="An import map that is right already: only the model is written."),
    ] = None,
    operating_points: Annotated[
        bool, typer.Option("--operating-points", help="Each row is a point: at rest, or at a constant speed.")
    ] = False,
    force: options.Force = False,
) -> None:
    """Write a first import map and a first model of a machine that is new here, from its recordings.

    Columns are known by their names and units; units that no name tells, the gear ratio, the encoders' counts and the
    drive's gains are found from the numbers. What could not be found is marked CHECK in both files: look at these lines
    before you believe a result.
    """
    from ema_bench_replay.configuration import find_configuration

    from ..model.model_file import check_model_name
    from ..new_machine.drafts import checked_drafts
    from ..new_machine.given import Given
    from ..new_machine.other_traces import differing_columns
    from ..new_machine.told import assumed_units

    place = Path(output)
    if place.suffix.lower() in (".yaml", ".yml"):  # the name of the model, as other commands take it
        place = place.with_suffix("")
    files = place.with_name(f"{place.name}_map.yaml"), place.with_name(f"{place.name}.yaml")
    check_model_name(files[1])
    for path in files if import_map is None else files[1:]:
        if path.exists() and not force:
            raise InputError(f"{path}: exists already; give another name with -o, or --force to replace it")
    given = Given(place.name, gear_ratio, torque_constant)
    traces = traces or []
    if import_map is not None:
        _model_alone(traces, given, find_configuration("maps", import_map), files[1], force)
        return
    holed: tuple[Guess, ...] = ()
    if not traces:
        guesses, given = _asked(given)
    else:
        guesses, holed = _guessed(traces[0], gear_ratio, operating_points)
        _warn_of_contradicted_names(guesses)
        for sentence in differing_columns(traces[0], guesses, traces[1:]):
            warn(sentence)
    drafts = checked_drafts(guesses, given, traces)
    for path, text in zip(files, (drafts.map, drafts.model), strict=True):
        _write(path, text, force)
    if traces:
        for guess in guesses.signals:
            if guess.column not in drafts.left_out:
                say(f"{guess.column} → {guess.signal}{_in_unit(guess)}")
        for column in drafts.left_out:
            say(f"{column}: the drive's torque does not follow it, so it is not the load: not used")
        _warn_of_foreign_units(guesses)
        joint = (guesses.joint.sentence,) if guesses.joint.number else ()
        _say_what_it_rests_on(files[1], (*joint, *assumed_units(guesses), *drafts.assumed))
    for question in drafts.questions:
        warn(question)
    _say_next(files, drafts, guesses, " ".join(quote(str(trace)) for trace in traces) or "TRACE.csv", holed)


def _model_alone(traces: Sequence[Path], given: Given, map_file: Path, place: Path, force: bool) -> None:
    """Write the model of recordings whose map there is."""
    from ema_bench_replay.load import load
    from ema_bench_replay.recording import AT

    from ..new_machine.drafts import checked_model
    from ..new_machine.shaft import Shaft

    if not traces:
        raise InputError("init: --map reads recordings; name one, or leave --map out to be asked")
    recordings = [load(trace, import_map=map_file) for trace in traces]
    shaft = Shaft(recordings[0].metadata.get(f"motor_position{AT}", "motor"), given.gear_ratio)
    model = checked_model(recordings, given, shaft)
    _write(place, model.text, force)
    _say_what_it_rests_on(place, model.assumed)
    for question in model.questions:
        warn(question)
    say(f"{place}: {_to_look_at(model.text)}")
    names = " ".join(quote(str(trace)) for trace in traces)
    say(f"Then:\n  ema-twin discover {names} --map {quote(str(map_file))} --model {quote(str(place))} -o found.yaml")


def _warn_of_contradicted_names(guesses: Guesses) -> None:
    """Warn of columns whose name tells one quantity and whose unit another, as where two units were swapped."""
    from ..new_machine.columns import contradicted_quantity
    from ..new_machine.header_words import header_words

    for guess in guesses.signals:
        if said := contradicted_quantity(guess.column):
            unit = header_words(guess.column)
            warn(
                f"{guess.column}: its name says {said}, its unit {unit.unit} is one of {unit.quantity}: read as "
                f"{guess.signal.replace('_', ' ')}; where the unit is wrong, correct the header and run init again"
            )


def _warn_of_foreign_units(guesses: Guesses) -> None:
    """Warn of columns whose header tells a unit that is none of their signal's, as per cent of a rated torque."""
    from ema_bench_replay.units import signal_unit

    from ..new_machine.header_words import header_words

    for guess in guesses.signals:
        foreign = header_words(guess.column).foreign
        if guess.unit is None and foreign and not foreign.isdigit():
            signal, unit = guess.signal.replace("_", " "), signal_unit(guess.signal, guesses.motion)
            warn(
                f"{guess.column}: {foreign} is no unit of the {signal}: read as if one were one {unit}, and so is all "
                "that is told in it; write what one is worth as the signal's `factor` in the map"
            )


def _say_what_it_rests_on(place: Path, besides: Sequence[str]) -> None:
    """Say what the recordings showed of the machine, what the model only assumes, and what else was, ``besides``."""
    from ..model import load_model
    from ..new_machine.told import assumed, shown

    model = load_model(place)
    for text, numbers in (("Known", shown(model)), ("Assumed", assumed(model))):
        if numbers:
            say(f"{text}: {', '.join(numbers)}")
    for sentence in besides:
        say(f"Assumed: {sentence}")


def _to_look_at(text: str) -> str:
    """How many lines of a draft a person should look at; its first two tell of the mark itself."""
    from ..new_machine.check_comment import CHECK

    count = sum(CHECK in line for line in text.splitlines()[2:])
    return f"{count} line(s) to look at, marked {CHECK}" if count else "nothing was left to guess"


def _guessed(trace: Path, gear_ratio: float | None, of_points: bool) -> tuple[Guesses, tuple[Guess, ...]]:
    """What the columns of a trace seem to be, and what those would be that are left out because of a few cells.

    Its rows are operating points where they are said to be (``of_points``), or seem so. Raises InputError where nothing
    can be told of them.
    """
    import numpy as np

    from ema_bench_replay.traces.trace_table import read_table

    from ..new_machine.columns import guess_columns
    from ..new_machine.rows import with_kind_of_rows
    from ..new_machine.turns import counted_on_turns
    from ..new_machine.units_by_numbers import with_units

    table = read_table(trace, needed=lambda header: ())
    numbers = dict(zip(table.header, table.columns, strict=True))
    no_numbers = {
        name: int(np.count_nonzero(np.isnan(column))) for name, column in numbers.items() if np.isnan(column).any()
    }
    try:
        guesses = guess_columns(table.header, frozenset(no_numbers), numbers)
    except InputError as error:
        raise InputError(f"{trace}: {error}") from None
    try:
        guesses = with_kind_of_rows(guesses, numbers, of_points)
    except InputError as error:
        raise InputError(f"{trace}: header: none of {', '.join(table.header)[:200]} is the time, and {error}") from None
    guesses = with_units(*counted_on_turns(guesses, numbers), gear_ratio)
    rows = len(table.columns[0])
    empty = frozenset(name for name, count in no_numbers.items() if count == rows)
    holed = tuple(guess for guess in guess_columns(table.header, empty).signals if guess.column in no_numbers)
    for name, count in no_numbers.items():
        if not name and count == rows:
            continue  # what follows a delimiter at the end of each line
        said = f"{name or 'a column without a name'}: {count} of {rows} cells hold no number: not used"
        if any(guess.column == name for guess in holed):
            first = int(np.flatnonzero(np.isnan(numbers[name]))[0]) + 1
            said += f"; to have it read, remove the rows that lack it (the first is row {first} of the numbers)"
        say(said)
    if not guesses.signals:
        raise InputError(
            f"{trace}: header: none of {', '.join(table.header)[:200]} tells what it is; rename its columns, as in "
            "'time [s]', 'current [A]', 'motor position [rad]' (a Siemens drive's trace needs no map: leave init out)"
        )
    return guesses, holed


def _in_unit(guess: Guess) -> str:
    """The unit that a column is read in, in words."""
    from ..new_machine.header_words import COUNTS

    if guess.unit == COUNTS:
        return f", {guess.counts:g} counts a turn" if guess.counts else ", its counts a turn unknown"
    return f" in {guess.unit}" if guess.unit else ", unit unknown"


def _asked(given: Given) -> tuple[Guesses, Given]:
    """What the columns are said to be, and the machine's numbers; each answer is checked as it is given."""
    from ..new_machine.columns import named_columns

    asked = {signal: str(_ask(text, "")).strip() for signal, text in _QUESTIONS.items()}
    named = {signal: column for signal, column in asked.items() if column}
    if not named.keys() & {"current", "motor_torque"} or not named.keys() & {"motor_position", "speed"}:
        raise InputError("init: a model needs a current or a torque, and a motor's position or speed; answer these")
    guesses = named_columns(named)
    ratio = given.gear_ratio or float(_ask("Turns of the motor per turn of the output", 1.0))
    if not ratio >= LEAST_RATIO:
        raise InputError(f"init: a gear ratio of {ratio:g} is none; give {LEAST_RATIO:g} or more")
    shaft = given.shaft
    if shaft is None and ratio != 1.0 and "motor_position" in named:
        shaft = str(_ask("Whose turns does the motor's position count, motor or output", SHAFTS[0])).strip().lower()
        if shaft not in SHAFTS:
            raise InputError(f"init: '{shaft}' is no shaft; say {' or '.join(SHAFTS)}")
    constant = given.torque_constant
    if constant is None and "current" in named:
        constant = float(_ask("Torque per ampere [N m/A], or force [N/A] (0: not known)", 0.0)) or None
    return guesses, replace(given, gear_ratio=ratio, torque_constant=constant, shaft=shaft)


def _ask(question: str, usual: str | float) -> str | float:
    answer: str | float = typer.prompt(question, default=usual, show_default=usual != "", type=type(usual))
    return answer


def _write(path: Path, text: str, force: bool) -> None:
    from ema_bench_replay.outputs import new_file

    with new_file(path, force=force) as file:
        file.write(text.encode())


def _say_next(
    files: tuple[Path, Path], drafts: Drafts, guesses: Guesses, trace: str, holed: tuple[Guess, ...] = ()
) -> None:
    """Say what was written, and what comes next; ``holed`` are columns that were left out because of a few cells."""
    for path, text in zip(files, (drafts.map, drafts.model), strict=True):
        say(f"{path}: {_to_look_at(text)}")
    if why := guesses.points_doubt:
        say(f"{why[:1].upper()}{why[1:]}: each row is taken for an operating point, at rest or at constant speed.")
    map_name, model = (quote(str(file)) for file in files)
    say("Then:")
    say(f"  ema-twin info {trace} --map {map_name}")
    if guesses.both_encoders and not guesses.drives:
        say("No current and no torque was found: play, delay and angle errors between the encoders show, no friction.")
    if guesses.drives or guesses.both_encoders:
        say(f"  ema-twin discover {trace} --map {map_name} --model {model} -o found.yaml")
        return
    mended = replace(guesses, signals=(*guesses.signals, *holed))
    if mended.drives or mended.both_encoders:
        names = " and ".join(guess.column for guess in holed)
        say(
            f"  Without {names} nothing can be judged: write the numbers that it lacks into {trace}, or remove these "
            "rows, and run init again."
        )
    else:
        say(f"  No current and no torque was found: name its column in {files[0]}, or nothing can be judged.")

"""What ``ema-twin init`` prints about its drafts: what they are based on, what to check, what to do next."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from shlex import quote

from ema_bench_replay.traces.header_words import COUNTS, header_words
from ema_bench_replay.traces.import_map import load_map
from ema_bench_replay.units import signal_unit, units_of

from ..listing import number_of
from ..model import load_model
from ..model.check_comment import CHECK, REMEDIES, START_VALUE
from ..new_machine.column_quantity import contradicted_quantity
from ..new_machine.columns import Guess, Guesses
from ..new_machine.drafts import Drafts
from ..new_machine.lengths import is_of_turns
from ..new_machine.told import assumed, doubts_of, estimated, shown
from ..new_machine.unused_columns import beside_those_taken, with_unknown_units
from ..new_machine.voltages import voltages
from .output import say, warn

_NOTHING = {True: "no line to check", False: "no line to check, but a signal is missing: see below"}
_OPEN = "inertia and friction are open: start values only, which fit or discover replace"
_MOST_REASONS = 4  # shown of one file
_MOST_COLUMNS = 8  # shown of those with the same reason


def warn_of_contradicted_names(guesses: Guesses) -> None:
    """Warn of columns whose name says one quantity and whose unit another, for example if two units were swapped."""
    for guess in guesses.signals:
        if said := contradicted_quantity(guess.column, guess.unit):
            unit = header_words(guess.column)
            warn(
                f"{guess.column}: its name says {said}, its unit {unit.unit} is one of {unit.quantity}: read as "
                f"{guess.signal.replace('_', ' ')}; where the unit is wrong, correct the header and run init again"
            )


def warn_of_foreign_units(guesses: Guesses) -> None:
    """Warn of columns whose header has a unit that does not fit their signal, such as per cent of a rated torque."""
    for guess in guesses.signals:
        if foreign := guess.foreign_unit:
            signal, unit = guess.signal.replace("_", " "), signal_unit(guess.signal, guesses.motion)
            warn(
                f"{guess.column}: '{foreign}' is not a unit of the {signal}; the values are read as {unit}, and all "
                "results scale with that. Give the conversion as the signal's `factor` in the map"
            )


def say_unused(guesses: Guesses, columns: Sequence[str]) -> None:
    """Print why those of the ``columns`` that may be meant are not used: their unit, or another column."""
    if electrical := guesses.electrical:
        say(
            f"Not used, since their numbers are the voltages and powers of a power analyser: {_shortened(electrical)} "
            "(if one is a shaft's, say so in its name, as in 'motor speed [rpm]', and run init again)"
        )
    units = with_unknown_units(columns)
    if units:
        say(
            f"Not used, since no signal is given in these units: {_shortened(units)} (if one is a signal, convert it "
            "to SI units, correct the header, and run init again)"
        )
    others = [name for name in beside_those_taken(guesses, columns) if name not in units]
    if others:
        say(
            f"Not used, since other columns are read in their place: {_shortened(others)} (if one is meant, remove the "
            "column that was taken, and run init again)"
        )


def ask_for_motion(unread: Sequence[str]) -> None:
    """Ask whether columns whose names tell nothing are a position or a speed, which no other column is."""
    _ask_for(unread, "position or speed", "'motor position [deg]' or 'motor speed [rpm]'")


def ask_for_drive(unread: Sequence[str]) -> None:
    """Ask the same about a current or a torque; what a controller gives out may command it."""
    _ask_for(unread, "current or torque", "'motor current [A]' or 'torque command [N m]'")


def _ask_for(unread: Sequence[str], what: str, names: str) -> None:
    one = len(unread) == 1
    unclear = "its name does not tell what it is" if one else "their names do not tell what they are"
    question = "is it one?" if one else "is one of them?"
    say(
        f"{_shortened(unread)}: not read, since {unclear}, and no {what} was found: {question} "
        f"Then say so in its name, as in {names}, and run init again"
    )


def say_unclear(columns: Sequence[str], motion: str) -> None:
    """Print that columns are not read that command something, or go as the motion does, and what to do about it."""
    unclear = "its name does not tell" if len(columns) == 1 else "their names do not tell"
    say(
        f"{_shortened(columns)}: not read, since {unclear} what is commanded or measured (if it is the position, say "
        f"so in the name, as in 'position command [{signal_unit('motor_position', motion)}]', and run init again)"
    )


def _shortened(names: Sequence[str]) -> str:
    more = f" and {len(names) - _MOST_COLUMNS} more" if len(names) > _MOST_COLUMNS else ""
    return f"{', '.join(names[:_MOST_COLUMNS])}{more}"


def say_what_it_rests_on(map_file: Path, place: Path, besides: Sequence[str], known: Sequence[str] = ()) -> str:
    """Print what the recordings showed of the machine, what the model assumes, and more of both; return it too.

    More assumptions are in ``besides``, and more that the recordings showed in ``known``.
    """
    model = load_model(place)
    at_output = any(read.signal == "motor_position" and read.at_output for read in load_map(map_file).signals)
    doubts = doubts_of(model, place.read_text(), map_file.read_text())
    numbers = {
        "Known": [*shown(model, doubts, at_output=at_output), *known],
        "Estimated from the recordings": estimated(model, doubts),
        "Assumed": assumed(model, doubts),
    }
    lines = [f"{text}: {', '.join(each)}" for text, each in numbers.items() if each]
    lines += [f"Assumed: {sentence}" for sentence in besides]
    for line in lines:
        say(line)
    return "\n".join(lines)


def say_what_to_look_at(place: Path, text: str, told: str, *, complete: bool = True) -> None:
    """Print how many lines of a draft to check, and why each is marked if that was not ``told`` before.

    Its first two lines, which explain the mark, do not count. ``complete``: whether the recordings hold what an
    analysis needs.
    """
    lines = text.splitlines()[2:]
    count = sum(CHECK in line for line in lines)
    parts = [f"{number_of(count, 'line')} to check, marked {CHECK}"] if count else []
    if any(START_VALUE in line for line in lines):
        parts.append(_OPEN)
    say(f"{place}: {'; '.join(parts) or _NOTHING[complete]}")
    reasons = _reasons(lines, told)
    for reason in reasons[:_MOST_REASONS]:
        say(f"  {reason}")
    if len(reasons) > _MOST_REASONS:
        say(f"  and {len(reasons) - _MOST_REASONS} more: see the file")


def _reasons(lines: Sequence[str], told: str) -> list[str]:
    """Why lines are to be checked, each by the name of its key, without what was ``told`` before.

    What replaces an assumed number was told beside that number.
    """
    found = []
    for line in lines:
        key, mark, reason = line.partition(f"  # {CHECK}: ")
        parts = [part for part in reason.split("; ") if part not in told and part not in REMEDIES.values()]
        if mark and parts:
            found.append(f"{key.strip().partition(':')[0]}: {'; '.join(parts)}")
    return found


def in_unit(guess: Guess) -> str:
    """The unit in which a column is read, in words."""
    if is_of_turns(guess.column) and guess.unit in units_of(guess.signal, "linear"):
        return f" in {header_words(guess.column).unit}, as of the slide"
    if guess.unit == COUNTS:
        return f", {guess.counts:g} counts per turn" if guess.counts else ", counts per turn unknown"
    if guess.unit is None:
        return ", unit unknown"
    return f" in {guess.unit}" if guess.factor == 1.0 else f" in steps of {guess.factor:.4g} {guess.unit}"


def say_next(
    files: tuple[Path, Path],
    drafts: Drafts,
    guesses: Guesses,
    traces: Sequence[str],
    holed: tuple[Guess, ...] = (),
    told: str = "",
) -> None:
    """Print what was written and what to do next with the ``traces``, quoted for a shell.

    ``told`` was printed before; ``holed`` are columns left out for cells that hold no number.
    """
    trace = " ".join(traces)
    moves = any(guess.signal in ("motor_position", "speed") for guess in guesses.signals)
    for path, text in zip(files, (drafts.map, drafts.model), strict=True):
        say_what_to_look_at(path, text, told, complete=moves or path != files[0])
    if why := guesses.points_doubt:
        say(f"{why[:1].upper()}{why[1:]}: each row is read as an operating point, at rest or at constant speed.")
    unsigned = " and ".join(guess.column for guess in guesses.signals if guess.magnitude)
    if _is_judgeable(guesses) and not guesses.drives:
        missed = "No current or torque with a sign" if unsigned else "No current or torque"
        say(f"{missed} was found: only backlash, delay and angle errors of the encoders can be found.")
    say("Then:")
    say(f"  ema-twin info {traces[0]} --map {quote(str(files[0]))}")
    if guesses.drives and not moves:
        say(
            f"  No motor position or speed was found: add its column to {files[0]}; no missing effect can be told "
            "without."
        )
        return
    if _is_judgeable(guesses):
        say_search(trace, *files)
        return
    if _is_judgeable(replace(guesses, signals=(*guesses.signals, *holed))):
        names = " and ".join(guess.column for guess in holed)
        say(
            f"  {names} cannot be left out: fill in the missing values in {trace}, or remove these rows, and run init "
            "again."
        )
    elif unsigned:
        say(f"  {unsigned} has no sign, so no twin can be driven: only the health can be judged (docs/health.md):")
        say(f"  ema-twin campaign FOLDER --do health --map {quote(str(files[0]))} -o results")
    else:
        say(f"  No current or torque was found: {_how_to_drive(files[0], guesses)}")


def _is_judgeable(guesses: Guesses) -> bool:
    """Whether an effect can be told from these signals: with a torque or, in the course of time, with both encoders."""
    return guesses.drives or (guesses.both_encoders and not guesses.of_points)


def _how_to_drive(map_file: Path, guesses: Guesses) -> str:
    """What to do without a current or torque: a voltage, or its duty cycle, may stand for the motor's torque."""
    if guesses.both_encoders:
        return (
            f"add its column to {map_file}, since operating points cannot be analysed without it; of samples of a "
            "motion, with both encoders, a column of the time is enough (add it to the file and run init again)."
        )
    if not (found := voltages(guesses)):
        return f"add its column to {map_file}; nothing can be analysed without it."
    return (
        f"add its column to {map_file}. If {_shortened(found)} commands the drive's torque, it can serve: write it "
        "into the line motor_torque that is prepared there, with its `gain` (a duty cycle also needs a `factor`: the "
        "supply's voltage over the value of full duty, as in 24 V over 100 %); nothing can be analysed without either."
    )


def say_search(traces: str, map_file: Path, model: Path) -> None:
    """Print the commands that look for what a drafted model lacks and show what was found.

    ``traces`` are quoted for a shell.
    """
    read, drafted, page = (quote(str(file)) for file in (map_file, model, model.with_suffix(".html")))
    given = f"{traces} --map {read} --model {drafted}"
    say(f"  ema-twin discover {given} -o found.yaml")
    say(f"  ema-twin compare {given} --model found.yaml")
    say(f"  ema-twin report {given} --model found.yaml -o {page}")

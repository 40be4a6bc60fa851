"""The draft of an import map, from the columns of a trace."""

from __future__ import annotations

import json

from ema_bench_replay.traces.header_words import COUNTS, header_words
from ema_bench_replay.units import signal_unit

from ..model.check_comment import CHECK, check_comment
from .columns import Guess, Guesses
from .lengths import is_of_turns
from .shaft import Shaft

ASSUMED_COUNTS = 4096
HOW_TO_GIVE_COUNTS = (
    "give the counts per turn, all edges counted, as `counts_per_revolution` in the map, and draft the model again "
    "with init --map"
)


def draft_map(guesses: Guesses, trace: str, shaft: Shaft) -> str:
    """YAML of an import map that reads a trace with these columns; ``shaft`` is that of the motor's position."""
    lines = [
        f"# First import map of {trace}, guessed from its header. Look at every line that says {CHECK}.",
        "version: 1",
        f"description: {json.dumps(trace)}",
    ]
    if guesses.motion != "rotary":
        lines.append(f"motion: {guesses.motion}")
    if guesses.of_points:
        doubt = f"{guesses.points_doubt}; each row is read as an operating point" if guesses.points_doubt else ""
        lines.append(f"operating_points: true{check_comment(doubt)}")
    if guesses.time is not None:
        unit = guesses.time.unit or "s"
        doubt = check_comment(guesses.time.doubt if guesses.time.unit else "the header names no unit")
        lines.append(f"time: {{column: {quoted(guesses.time.column)}, unit: {unit}}}{doubt}")
    if guesses.joint.name:
        lines.append(f"# {CHECK}: {guesses.joint.sentence}")
    lines.append("signals:")
    lines += [_signal_line(guess, guesses.motion, shaft) for guess in guesses.signals]
    if not guesses.drives and not any(guess.magnitude for guess in guesses.signals):
        without = (
            "so only the difference between the two encoders can be analysed"
            if guesses.both_encoders
            else "which every analysis needs"
        )
        lines.append(
            f"# {CHECK}: no current or torque was found, {without}. If a voltage commands the drive's torque, map it "
            "like this:"
        )
        unit = signal_unit("motor_torque", guesses.motion)
        lines.append(f"#  motor_torque: {{columns: ['…'], unit: V, gain: {{value: …, unit: {unit}/V}}}}")
    if left := [name for name in guesses.left if name]:
        lines.append(f"# not used: {', '.join(left)}")
    return "\n".join(lines) + "\n"


def _signal_line(guess: Guess, motion: str, shaft: Shaft) -> str:
    of_position = guess.signal == "motor_position"
    of_output = ", shaft: output" if (shaft.name if of_position else guess.shaft) == "output" else ""

    factor = -guess.factor if guess.turned_round else guess.factor
    turned = "" if factor == 1.0 else f", factor: {_number(f'{factor:.9g}')}"
    magnitude = ", magnitude: true" if guess.magnitude else ""
    wraps = f", wraps_after: {_period(guess, motion)}" if guess.wraps_after else ""
    jumps = f"its jumps are those of a position that starts again after {wrapped_after(guess)}" if wraps else ""
    of_load = guess.signal == "load_torque"
    why = "the drive's torque falls when it rises" if of_load else "it acts against the motion"
    if guess.signal.startswith("output"):
        why = "the output turns against the motor"
    sign = f"sign reversed: {why}" if guess.turned_round else ""
    shown = f"  # {sign}" if sign and not of_load else ""  # without a mark: the positions show it
    if not shown and motion == "linear" and is_of_turns(guess.column):
        shown = "  # of the motor, by the slide's way per turn"
    counted = guess.unit == COUNTS
    if counted:
        unit = f"counts_per_revolution: {guess.counts or ASSUMED_COUNTS:g}"
        unsure = guess.doubt if guess.counts else HOW_TO_GIVE_COUNTS
    else:
        unit = f"unit: {guess.unit or signal_unit(guess.signal, motion)}"
        unsure = guess.doubt if guess.unit else _unit_doubt(guess.column)
    size = "looks like a magnitude without sign: drives no twin" if guess.magnitude else ""
    command = "a command: the drive is assumed to follow it" if guess.command else ""
    of_shaft = shaft.doubt if of_position else guess.shaft_doubt
    doubts = (unsure, jumps, sign if of_load else "", size, command, of_shaft, guess.origin_doubt)
    doubt = check_comment("; ".join(filter(None, doubts))) or shown
    if of_position and not doubt and not of_output and motion != "linear" and not counted:
        doubt = "  # at the motor's shaft; add `shaft: output` if it is the output's"
    keys = f"{unit}{turned}{wraps}{of_output}{magnitude}"
    return f"  {guess.signal}: {{columns: [{quoted(guess.column)}], {keys}}}{doubt}"


def wrapped_after(guess: Guess) -> str:
    """After how much a position starts again, in words."""
    unit = {None: "of its units", COUNTS: "counts"}.get(guess.unit, guess.unit)
    return f"{guess.wraps_after:.6g} {unit}"


def _period(guess: Guess, motion: str) -> str:
    """The value of the key for a position that starts again, with a unit."""
    if guess.unit == COUNTS:
        return f"{{value: {(guess.wraps_after or 0.0) / (guess.counts or ASSUMED_COUNTS):.10g}, unit: rev}}"
    unit = guess.unit or signal_unit(guess.signal, motion)
    return f"{{value: {_number(f'{guess.wraps_after:.10g}')}, unit: {unit}}}"


def _number(text: str) -> str:
    """A number as YAML reads one: 9.0e-05, not 9e-05, which is a text to it."""
    return text if "." in text else text.replace("e", ".0e")


def _unit_doubt(column: str) -> str:
    """What to check about the unit of a column whose header has no known one."""
    foreign = header_words(column).foreign
    return f"'{foreign}' is not a known unit" if foreign and not foreign.isdigit() else "no unit in the header"


def quoted(column: str) -> str:
    """A column's name as a regular expression that matches only it, in single quotes.

    ``re.escape`` would escape its blanks and hyphens too, which is hard to read.
    """
    special = set(r".^$*+?{}[]\|()")
    plain = "".join("\\" + mark if mark in special else mark for mark in column)
    return "'" + plain.replace("'", "''") + "'"

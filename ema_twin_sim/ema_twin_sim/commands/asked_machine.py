"""The questions that ``ema-twin init`` asks if it is given no trace."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import typer

from ema_bench_replay.errors import InputError

from ..new_machine.columns import Guesses, named_columns
from ..new_machine.given import Given
from .options import GEAR_RATIO, TORQUE_CONSTANT, length

SHAFTS = "motor", "output"
_TRAVEL = "Way of the slide per turn of its motor, as in '5 mm' (leave empty for a motor that does not turn)"
_RATIO = "Turns of the motor per turn of the output"
_CONSTANT = "Torque per ampere [N m/A], or force [N/A] (0: not known)"
_GIVE_A_TRACE = "give a trace, whose columns answer it: ema-twin init TRACE.csv -o NAME"

_QUESTIONS = {
    "time": "Name of the time column, with its unit, as in 'time [s]'",
    "current": "Column of the motor's current, as in 'current [A]' (leave empty if there is none)",
    "motor_torque": "Column of the motor's torque or force, as in 'torque [Nm]' (leave empty if there is none)",
    "motor_position": "Column of the motor's position, as in 'motor position [rad]'",
    "speed": "Column of the motor's speed, as in 'speed [rpm]' (leave empty if there is none)",
    "output_position": "Column of the output's position, as in 'output position [deg]' (leave empty if there is none)",
}


def asked(given: Given) -> tuple[Guesses, Given]:
    """Ask for the columns and the machine's numbers; return both. Each answer is checked as it is given."""
    answers = {signal: _ask(text, "") for signal, text in _QUESTIONS.items()}
    named = {signal: column for signal, column in answers.items() if column}
    if not named.keys() & {"current", "motor_torque"} or not named.keys() & {"motor_position", "speed"}:
        raise InputError("init: a model needs a current or a torque, and a motor's position or speed; answer these")
    guesses = named_columns(named)
    if guesses.motion == "linear":
        return guesses, _of_slide(given, has_current="current" in named)
    ratio = given.gear_ratio or _parsed(GEAR_RATIO, _ask(_RATIO, "1", "give --gear-ratio"))
    shaft = given.shaft
    if shaft is None and ratio != 1.0 and "motor_position" in named:
        shaft = _ask("Does the motor's position count turns of the motor or of the output", SHAFTS[0]).lower()
        if shaft not in SHAFTS:
            raise InputError(f"init: '{shaft}' is not a shaft; answer {' or '.join(SHAFTS)}")
    given = _with_constant(given) if "current" in named else given
    return guesses, replace(given, gear_ratio=ratio, shaft=shaft)


def _of_slide(given: Given, *, has_current: bool) -> Given:
    """What is known of a slide: a way per turn and a torque constant if it ``has_current``, which they make a force."""
    if not has_current:
        return given
    if given.travel_per_turn is None and (said := _ask(_TRAVEL, "", "give --travel-per-turn")):
        given = replace(given, travel_per_turn=_parsed(length, said))
    return _with_constant(given)


def _with_constant(given: Given) -> Given:
    """The same with the torque constant that is answered, if none was given."""
    if given.torque_constant is not None:
        return given
    said = _ask(_CONSTANT, "0", "give --torque-constant")
    return given if said == "0" else replace(given, torque_constant=_parsed(TORQUE_CONSTANT, said))


def _parsed(parser: Callable[[str], float], answer: str) -> float:
    """The number of an answer, within the limits of the option that gives it otherwise."""
    try:
        return parser(answer)
    except typer.BadParameter as error:
        raise InputError(f"init: {error.message}") from None


def _ask(question: str, usual: str, remedy: str = _GIVE_A_TRACE) -> str:
    """The answer to a question; if the input ends there, InputError with the ``remedy``, which answers it otherwise."""
    try:
        answer = str(typer.prompt(question, default=usual, show_default=usual != "")).strip()
    except typer.Abort as abort:
        if not isinstance(abort.__context__, EOFError):
            raise
        typer.echo()
        raise InputError(f'init: the input ended before an answer to "{question}"; {remedy}') from None
    return answer

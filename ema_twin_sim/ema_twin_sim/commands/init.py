"""``ema-twin init``: a first import map and a first model of a new machine."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ema_bench_replay.errors import InputError

from . import options
from .output import say

if TYPE_CHECKING:
    from ..new_machine.drafts import Given

EXAMPLES = """Examples:

ema-twin init trace.csv -o press

ema-twin init trace.csv -o press --gear-ratio 50 --torque-constant 0.8

ema-twin init -o press      (asks which columns your traces have)"""

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
    trace: Annotated[
        Path | None, typer.Argument(metavar="[TRACE]", help="A CSV of the machine; without it, questions are asked.")
    ] = None,
    gear_ratio: Annotated[
        float | None, typer.Option(min=1e-3, metavar="RATIO", help="Turns of the motor per turn of the output.")
    ] = None,
    torque_constant: Annotated[
        float | None, typer.Option(min=1e-6, metavar="N_M_PER_A", help="Torque (N m, or N) per ampere.")
    ] = None,
    force: options.Force = False,
) -> None:
    """Write a first import map and a first model of a machine that is new here, from the header of a CSV.

    What could not be guessed is marked CHECK in both files: look at these lines before you believe a result.
    """
    from ..model.model_file import check_model_name
    from ..new_machine.drafts import Given

    place = Path(output)
    files = place.with_name(f"{place.name}_map.yaml"), place.with_name(f"{place.name}.yaml")
    check_model_name(files[1])
    for path in files:
        if path.exists() and not force:
            raise InputError(f"{path}: exists already; give another name with -o, or --force to replace it")
    given = Given(place.name, gear_ratio, torque_constant)
    if trace is None:
        _from_answers(files, given, force)
    else:
        _from_trace(trace, files, given, force)


def _from_trace(trace: Path, files: tuple[Path, Path], given: Given, force: bool) -> None:
    from ema_bench_replay.load import load
    from ema_bench_replay.traces.trace_table import read_table

    from ..new_machine.columns import guess_columns
    from ..new_machine.drafts import draft_map, draft_model

    header = read_table(trace).header
    guesses = guess_columns(header)
    if not guesses.signals:
        raise InputError(
            f"{trace}: header: none of {', '.join(header)[:200]} tells what it is; name its columns in a copy of a "
            "shipped map (--map siemens reads a Siemens drive's trace as it is)"
        )
    _write(files[0], draft_map(guesses, trace.name), force)
    recording = load(trace, import_map=files[0])
    _write(files[1], draft_model(recording, given), force)
    for guess in guesses.signals:
        say(f"{guess.column} → {guess.signal}{f' in {guess.unit}' if guess.unit else ', unit unknown'}")
    _say_next(files, str(trace))


def _from_answers(files: tuple[Path, Path], given: Given, force: bool) -> None:
    import numpy as np

    from ema_bench_replay.recording import MOTION, Recording

    from ..new_machine.columns import Guess, Guesses, guess_columns
    from ..new_machine.drafts import Given, draft_map, draft_model

    asked = {
        signal: str(typer.prompt(text, default="", show_default=False)).strip() for signal, text in _QUESTIONS.items()
    }
    named = {signal: column for signal, column in asked.items() if column}
    if not named.keys() & {"current", "motor_torque"} or not named.keys() & {"motor_position", "speed"}:
        raise InputError("init: a model needs a current or a torque, and a motor's position or speed; answer these")
    heard = guess_columns(list(named.values()))
    units = {guess.column: guess.unit for guess in heard.signals}
    time = None if "time" not in named else heard.time or Guess("time", named["time"], None)
    signals = tuple(Guess(signal, column, units.get(column)) for signal, column in named.items() if signal != "time")
    guesses = Guesses(time, signals, (), heard.motion)
    ratio = given.gear_ratio or float(
        typer.prompt("Turns of the motor per turn of the output", default=1.0, type=float)
    )
    # nothing is recorded yet: what a recording would tell of the sensors is left out
    nothing = Recording(
        given.name,
        np.arange(2) * 1_000_000,
        {guess.signal: np.zeros(2) for guess in signals},
        metadata={MOTION: heard.motion} if heard.motion != "rotary" else {},
    )
    _write(files[0], draft_map(guesses, f"{given.name}'s traces"), force)
    _write(files[1], draft_model(nothing, Given(given.name, ratio, given.torque_constant)), force)
    _say_next(files, "TRACE.csv")


def _ask(question: str, usual: str | float) -> str | float:
    answer: str | float = typer.prompt(question, default=usual, show_default=usual != "", type=type(usual))
    return answer


def _write(path: Path, text: str, force: bool) -> None:
    from ema_bench_replay.outputs import new_file

    with new_file(path, force=force) as file:
        file.write(text.encode())


def _say_next(files: tuple[Path, Path], trace: str) -> None:
    import shlex

    from ema_bench_replay.traces.import_map import load_map

    from ..model import load_model
    from ..new_machine.drafts import CHECK

    load_map(files[0])
    load_model(files[1])
    doubtful = {path: path.read_text().count(CHECK) - 1 for path in files}
    for path, count in doubtful.items():
        say(f"{path}: {f'{count} line(s) to look at, marked {CHECK}' if count else 'nothing was left to guess'}")
    word, map_name, model = (shlex.quote(str(part)) for part in (trace, *files))
    if trace == "TRACE.csv":
        word = trace
    say("Then:")
    say(f"  ema-twin info {word} --map {map_name}")
    say(f"  ema-twin discover {word} --map {map_name} --model {model} -o better.yaml")

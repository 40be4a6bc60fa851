"""``ema-twin init``: a first import map and a first model of a new machine."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated

import typer

from ema_bench_replay.errors import InputError
from ema_bench_replay.outputs import write_text

from ..listing import by_recording
from . import options
from .output import say, warn

if TYPE_CHECKING:
    from ..new_machine.columns import Guess
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
        typer.Option(metavar="RATIO", parser=options.GEAR_RATIO, help="Turns of the motor per turn of the output."),
    ] = None,
    torque_constant: Annotated[
        float | None,
        typer.Option(
            metavar="N_M_PER_A",
            parser=options.TORQUE_CONSTANT,
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
        bool, typer.Option("--operating-points", help="Each row is an operating point: at rest, or at constant speed.")
    ] = False,
    force: options.Force = False,
) -> None:
    """Draft an import map and a model of a new machine from its recordings.

    Columns are recognised by their names and units. Missing units, the gear ratio, the encoders' counts and the drive's
    gains are estimated from the data. What could not be determined is marked CHECK in both files: check these lines
    before you trust a result.
    """
    from ema_bench_replay.configuration import find_configuration

    from ..new_machine.drafts import checked_drafts
    from ..new_machine.given import Given
    from ..new_machine.lengths import told_of_turns
    from ..new_machine.other_traces import differing_columns
    from ..new_machine.told import assumed_units
    from .asked_machine import asked
    from .guessed_columns import guessed_columns
    from .shown_draft import in_unit, say_next, say_what_it_rests_on, warn_of_contradicted_names, warn_of_foreign_units

    place = Path(output)
    if place.suffix.lower() in (".yaml", ".yml"):  # a model's file name, which other commands take
        place = place.with_suffix("")
    if not place.name:
        raise InputError(f"-o {output}: is a folder; add a name, as in -o {place / 'press'}")
    files = place.with_name(f"{place.name}_map.yaml"), place.with_name(f"{place.name}.yaml")
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
        guesses, holed = guessed_columns(traces[0], given, operating_points)
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
    from .shown_draft import say_search, say_what_it_rests_on, say_what_to_look_at

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

"""The options that several verbs share."""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, TypeVar

import typer

N = TypeVar("N", int, float)

LARGEST = 1e9
"""Upper limit of times [s], angles [rad] and factors on the command line."""


def number(lower: float, upper: float, unit: str) -> Callable[[str], float]:
    """Parser of an option that takes a number in ``unit``; anything else is a usage error that states the bounds."""
    return _within(float, "number", lower, upper, f"give {lower:g} to {upper:g} {unit}")


def length(text: str) -> float:
    """Parser of an option that takes a length [m] with its unit; a number alone is in m, and below 1."""
    from ema_bench_replay.units import units_of

    units = units_of("output_position", "linear")
    remedy = f"give a length with its unit, as in '5 mm' ({', '.join(units)})"
    found = re.fullmatch(r"\s*([-+.\d]+(?:e[-+]?\d+)?)\s*(\S*)\s*", text, re.IGNORECASE)
    try:
        value, unit = (float(found[1]), found[2]) if found else (math.nan, "")
    except ValueError:
        value, unit = math.nan, ""
    if math.isnan(value) or (unit and unit not in units):
        raise typer.BadParameter(f"{text} is no length; {remedy}")
    if not unit and value >= 1.0:
        raise typer.BadParameter(f"{text} has no unit; {remedy}")
    value *= units.get(unit, 1.0)
    if not 1e-7 <= value <= 100.0:
        raise typer.BadParameter(f"{text} is out of range; {remedy}, from 0.1 um to 100 m")
    return value


def bounded(metavar: str, lower: float, upper: float, unit: str, text: str) -> Any:
    """An option that takes a number in ``unit`` between two bounds."""
    return typer.Option(metavar=metavar, parser=number(lower, upper, unit), help=text)


def whole(lower: int, upper: int) -> Callable[[str], int]:
    """Parser of an option that takes a whole number; anything else is a usage error that states the bounds."""
    return _within(int, "whole number", lower, upper, f"give {lower} to {upper}")


def _within(read: Callable[[str], N], kind: str, lower: N, upper: N, bounds: str) -> Callable[[str], N]:
    def parsed(text: str) -> N:
        try:
            value = read(text)
        except ValueError:
            raise typer.BadParameter(f"{text} is no {kind}; {bounds}") from None
        if not lower <= value <= upper:
            raise typer.BadParameter(f"{text} is out of range; {bounds}")
        return value

    return parsed


def model_names(incomplete: str) -> list[str]:
    """Models of the configuration, and YAML files, whose names begin like this, for tab completion."""
    return _configured("models", incomplete)


def map_names(incomplete: str) -> list[str]:
    """Import maps of the configuration, and YAML files, whose names begin like this, for tab completion."""
    return _configured("maps", incomplete)


def _configured(kind: str, incomplete: str) -> list[str]:
    from ema_bench_replay.configuration import configuration_names

    files = [f"{path}/" if path.is_dir() else str(path) for path in _paths(incomplete)]
    names = [name for name in configuration_names(kind) if name.startswith(incomplete)]
    return [*names, *(file for file in files if file.endswith(("/", ".yaml", ".yml")))]


def _paths(incomplete: str) -> list[Path]:
    """Files and folders whose paths begin like this, as a shell completes them."""
    folder, slash, begin = incomplete.rpartition("/")
    try:
        inside = sorted(Path(f"{folder}{slash}" or ".").iterdir())
    except OSError:
        return []
    return [path for path in inside if path.name.startswith(begin) and (begin or not path.name.startswith("."))]


def effect_names(incomplete: str) -> list[str]:
    """Effects whose ids begin like this, for tab completion."""
    from ..effects import catalogue

    return [id for id in catalogue() if id.startswith(incomplete)]


def effects_of_model(ctx: typer.Context, incomplete: str) -> list[str]:
    """Effects of the model on this line, else of the catalogue, that begin like this, for tab completion."""
    from ema_bench_replay.errors import InputError

    from ..model import load_model

    try:
        names = list(load_model(ctx.params.get("model") or _model_on_line()).effects)
    except (KeyError, TypeError, InputError):
        return effect_names(incomplete)
    return [name for name in names if name.startswith(incomplete)]


def _model_on_line() -> str:
    """The model behind the cursor, where the command line's parser, which stops there, has not read it.

    Raises KeyError if there is none, or if the shell does not tell.
    """
    words = os.environ["COMP_WORDS"].split()
    for word, after in pairwise([*words, ""]):
        option, _, value = word.partition("=")
        if option in ("--model", "-m") and (value or after):
            return value or after
    raise KeyError("--model")


def input_names(incomplete: str) -> list[str]:
    """Inputs of a twin that begin like this, for tab completion."""
    from ..simulation.simulate import DRIVING

    return [name for name in DRIVING if name.startswith(incomplete)]


def of_json(path: Path | None) -> Path | None:
    """A path for JSON; a usage error if it is a folder, or a file that holds something else, which would be lost."""
    if path is not None and path.is_dir():
        raise typer.BadParameter(f"{path} is a folder; name a file")
    if path is not None and path.is_file():
        try:
            text = path.read_text("utf-8-sig")
            json.loads(text or "null")
        except (OSError, ValueError):
            raise typer.BadParameter(f"{path} exists and is no JSON file; give another name") from None
    return path


SECONDS = number(-LARGEST, LARGEST, "s")
GEAR_RATIO = number(1e-3, 1e5, "turns of the motor per turn of the output")
TORQUE_CONSTANT = number(1e-6, LARGEST, "N m/A (of a linear machine N/A)")

Runs = Annotated[list[Path], typer.Argument(metavar="RUN…", help="Recordings: MCAP files, CSVs, or folders of either.")]
Run = Annotated[Path, typer.Argument(metavar="RUN", help="A recording: MCAP file, folder that import wrote, or CSV.")]
Models = Annotated[
    list[str],
    typer.Option(
        "--model",
        "-m",
        help="Model file, or a name in config/models; give several to see them side by side.",
        autocompletion=model_names,
    ),
]
ModelName = Annotated[
    str, typer.Option("--model", "-m", help="Model file, or a name in config/models.", autocompletion=model_names)
]
EffectName = Annotated[
    str,
    typer.Argument(
        metavar="EFFECT",
        help="An effect of the catalogue, or the Python file of one of your own.",
        autocompletion=effect_names,
    ),
]
WithFiles = Annotated[
    list[Path] | None,
    typer.Option(
        "--with",
        "--effect-file",
        metavar="FILE.py",
        help="A Python file with an effect of your own. The file is executed. May be repeated.",
    ),
]
Without = Annotated[
    list[str] | None,
    typer.Option(
        "--without",
        "--exclude",
        metavar="EFFECT",
        help="Effect to exclude from the search. May be repeated.",
        autocompletion=effect_names,
    ),
]
Evidence = Annotated[
    Path | None,
    typer.Option(metavar="FILE.mcap", help="Also write the residuals of each step, for rerun, Foxglove, PlotJuggler."),
]
Rrd = Annotated[Path | None, typer.Option(metavar="FILE.rrd", help="Also write views for rerun.")]
NewModel = Annotated[Path, typer.Option("-o", "--output", metavar="NEW", help="The model file to write.")]
Results = Annotated[
    Path, typer.Option("-o", "--output", metavar="RESULTS", help="The folder of results; an existing one is continued.")
]
CORES = os.cpu_count() or 1
Workers = Annotated[
    int,
    typer.Option(metavar="N", parser=whole(1, 1024), help="Processes on this machine; by default one for each core."),
]
Scheduler = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS",
        help="A dask scheduler (tcp://HOST:PORT) to use instead of this machine; its workers must see the same files.",
    ),
]
Rate = Annotated[
    float,
    typer.Option(
        metavar="TIMES",
        parser=number(0.0, 1000.0, "times real time (0: as fast as possible)"),
        help="Replay speed relative to real time; 0: as fast as possible.",
    ),
]
ImportMap = Annotated[
    str, typer.Option("--map", help="Import map of CSVs: a file or a name in config/maps.", autocompletion=map_names)
]
From = Annotated[
    float | None, typer.Option("--from", metavar="S", parser=SECONDS, help="Start at this time, in seconds.")
]
To = Annotated[float | None, typer.Option("--to", metavar="S", parser=SECONDS, help="End at this time, in seconds.")]
Input = Annotated[
    str | None,
    typer.Option(
        help="Input of the twin: setpoint, current or command; by default chosen from the recording's signals.",
        autocompletion=input_names,
    ),
]
Step = Annotated[
    float | None,
    typer.Option(metavar="S", parser=SECONDS, help="Integration step in seconds; by default the model's."),
]
JsonFile = Annotated[
    Path | None,
    typer.Option("--json", metavar="FILE", callback=of_json, help="Also write the result here, machine-readable."),
]
Strict = Annotated[bool, typer.Option("--strict", help="Refuse damaged input instead of using its intact part.")]
Force = Annotated[bool, typer.Option("--force", help="Replace an output that exists.")]

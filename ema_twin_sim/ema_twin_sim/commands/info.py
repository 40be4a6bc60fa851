"""``ema-twin info``: what a recording or a model holds."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.markup import escape

from ema_bench_replay.units import signal_unit

from ..listing import number_of
from ..quantities import quantity
from . import options
from .output import console, say
from .tables import ReportTable, with_unit

if TYPE_CHECKING:
    from ..simulation.figures import Figure

EXAMPLES = """Examples:

ema-twin info recordings/BancoEMA_ramp_0.05

ema-twin info polito_bench"""


def run(
    what: Annotated[str, typer.Argument(metavar="RUN|MODEL", help="A recording, a model file or a model's name.")],
    with_files: options.WithFiles = None,
    import_map: options.ImportMap = "siemens",
    json: options.JsonFile = None,
) -> None:
    """Show the contents of a recording (signals, gaps, origin) or of a model."""
    from ema_bench_replay.configuration import configuration_names

    from .inputs import refuse_inputs

    path = Path(what)
    refuse_inputs([path, *(with_files or ())], json)
    if path.suffix in (".yaml", ".yml") or (not path.exists() and what in configuration_names("models")):
        _show_model(what, with_files or [], json)
    else:
        _show_recording(path, import_map, json)


def _show_recording(path: Path, import_map: str, json: Path | None) -> None:
    from ema_bench_replay.long_columns import extremes, mean_of
    from ema_bench_replay.recording import LACKED

    from .inputs import load_runs, write_json

    contents = []
    for recording in load_runs([path], import_map=import_map):
        name = escape(recording.name)
        points = recording.of_points
        held = (
            f"{len(recording)} operating points" if points else f"{len(recording)} samples, {recording.duration:.3f} s"
        )
        say(f"[bold]{name}[/bold]: {held}", markup=True)
        table = ReportTable()
        table.words("signal")
        table.numbers("min", "mean", "max")
        signals = {}
        for name, values in recording.signals.items():
            unit = signal_unit(name, recording.motion)
            least, greatest = extremes(values)
            numbers = {"least": least, "mean": float(mean_of(values)), "greatest": greatest}
            table.add_row(name, *(quantity(number, unit) for number in numbers.values()))
            signals[name] = {"unit": unit, **numbers}
        console.print(table)
        if not points:
            say(f"sample period {quantity(recording.sample_period, 's')}; {number_of(len(recording.gaps), 'gap')}")
        for key, value in recording.metadata.items():
            if "\n" not in value and len(value) < 200 and not key.endswith(LACKED):  # a warning tells that
                say(f"  {key}: {value}")
        contents.append(
            {
                "name": recording.name,
                "samples": len(recording),
                "duration": recording.duration,
                "sample_period": recording.sample_period,
                "signals": list(recording.signals),
                "statistics": signals,
                "gaps": [gap._asdict() for gap in recording.gaps],
                "metadata": {key: value for key, value in recording.metadata.items() if not key.endswith(LACKED)},
                "warnings": list(recording.warnings),
            }
        )
    write_json(json, contents[0] if len(contents) == 1 else contents)


def _show_model(name: str, with_files: list[Path], json: Path | None) -> None:
    from ..model import load_model
    from ..model.model_file import ABSENT, OPEN
    from ..own_effects import load_effects
    from .inputs import write_json

    load_effects(with_files)
    model = load_model(name)
    kinds = ", ".join(map(" ".join, model.kinds.items()))
    if model.choices:
        kinds += "; " + ", ".join(f"{path.partition('.')[2]} {choice}" for path, choice in model.choices.items())
    say(f"[bold]{escape(model.name)}[/bold]: machine {escape(model.machine)}; {kinds}", markup=True)
    table = ReportTable()
    table.words("constant")
    table.numbers("value", justify="left")
    table.numbers("±")
    table.words("source")
    given = {path: held for path, held in model.constants.items() if held.source != ABSENT}
    for path, held in given.items():
        tolerance = OPEN if math.isinf(held.tolerance) else f"{100 * held.tolerance:g} %"
        value = with_unit(held.value, model.unit(path))
        table.add_row(model.shown_path(path), value, tolerance, escape(held.source))
    console.print(table)
    effects = ReportTable()
    effects.words("effect", "options", "parameters")
    for instance_name, instance in model.effects.items():
        effects.add_row(
            instance_name + ("" if instance.enabled else " (off)") + (" (open)" if instance.open else ""),
            ", ".join(f"{k} {v}" for k, v in instance.options.items()),
            ", ".join(
                f"{k} {with_unit(v, model.parameter_unit(instance.effect, k))}" for k, v in instance.parameters.items()
            ),
        )
    console.print(effects)
    found = []
    if set(model.kinds.values()) - {"averaged", "rigid"}:
        from ..simulation.figures import figures

        found = figures(model)
        console.print(_figures(found))
    write_json(
        json,
        {
            "name": model.name,
            "machine": model.machine,
            "kinds": dict(model.kinds),
            "choices": dict(model.choices),
            "motion": model.motion,
            "constants": {
                model.shown_path(path): {
                    "value": held.value,
                    "tolerance": OPEN if math.isinf(held.tolerance) else held.tolerance,
                    "source": held.source,
                    "unit": model.unit(path),
                }
                for path, held in given.items()
            },
            "effects": {
                n: {
                    "effect": i.effect,
                    "options": dict(i.options),
                    "parameters": dict(i.parameters),
                    "units": {parameter: model.parameter_unit(i.effect, parameter) for parameter in i.parameters},
                    "enabled": i.enabled,
                }
                for n, i in model.effects.items()
            },
            "figures": [figure.as_json() for figure in found],
        },
    )


def _figures(found: Sequence[Figure]) -> ReportTable:
    table = ReportTable("\nDerived quantities")
    table.words("figure")
    table.numbers("value", justify="left")
    table.words("note")
    for figure in found:
        if isinstance(figure.value, str):
            short = len(figure.value) <= len("99.99 N m/rad")
            table.add_row(figure.name, figure.value if short else "", figure.note if short else figure.value)
        else:
            shown = f"{figure.value:.4g}" if figure.unit == "1" else quantity(figure.value, figure.unit, 4)
            table.add_row(figure.name, shown, figure.note)
    return table

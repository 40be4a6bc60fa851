"""``ema-twin plan``: the recording to make next."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from . import options
from .output import say, status

if TYPE_CHECKING:
    from ema_bench_replay.recording import Recording

    from ..discovery.experiment.bench_limits import Limits
    from ..model import Model

EXAMPLES = """Examples:

ema-twin plan bench/*.CSV --model polito_bench

ema-twin plan ramp.mcap --model polito_bench -o next.yaml

ema-twin simulate --command next.yaml --model polito_bench -o next.mcap     (as the virtual bench would answer)

ema-twin plan ramp.mcap --model polito_bench --max-travel 1.5 --max-speed 0.1"""


def _limit(metavar: str, unit: str, text: str) -> Any:
    """An option that takes a limit of the command in ``unit``."""
    return options.bounded(metavar, 1e-9, options.LARGEST, unit, text)


def run(
    runs: options.Runs,
    model: options.ModelName,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="COMMAND.yaml",
            help="Also write the command, for simulate --command. No file is written if there is nothing to propose.",
        ),
    ] = None,
    max_speed: Annotated[
        float | None,
        _limit("SPEED", "rad/s (m/s if linear)", "Limit of the output's speed, rad/s (m/s if the machine is linear)."),
    ] = None,
    max_travel: Annotated[
        float | None,
        _limit(
            "TRAVEL",
            "rad (m if linear)",
            "Limit of the output's travel from the start in either direction, rad (m if the machine is linear).",
        ),
    ] = None,
    max_current: Annotated[float | None, _limit("A", "A", "Limit of the motor's current, A.")] = None,
    max_torque: Annotated[
        float | None,
        _limit(
            "TORQUE",
            "N m (N if linear)",
            "Limit of the motor's torque, N m (force, N, if the machine is linear); for recordings without a current.",
        ),
    ] = None,
    with_files: options.WithFiles = None,
    without: options.Without = None,
    import_map: options.ImportMap = "siemens",
    start: options.From = None,
    end: options.To = None,
    strict: options.Strict = False,
    force: options.Force = False,
    json: options.JsonFile = None,
) -> None:
    """Propose the next recording: the command that tells apart the effects in doubt, and shows what was not shown yet.

    The command stays within the recorded speed, travel and current, unless only a larger one resolves more doubts or
    shows more effects; plan then says so. It asks for twice the recorded current and speed at most; for more speed only
    if the model states the drive's speed limit. Without end stops in the model, a carriage keeps to the recorded
    travel, and a shaft to twice that; if the model states the drive's speed limit, a shaft may turn as far as twice the
    recorded speed leads in one recording. A limit given as an option replaces the recorded one and is never exceeded;
    the others then stay as recorded.
    """
    from .inputs import check_outputs, input_files, write_json

    check_outputs(input_files(runs, [model], import_map, with_files), force, command=output, json=json)

    from ema_bench_replay.outputs import new_file

    from ..discovery.plan import plan
    from ..simulation.command import write_command
    from .judged import read_judged, warn_of
    from .shown_plan import show_how, show_plan

    recordings, (before,), excluded = read_judged(
        runs, [model], with_files, without, import_map=import_map, start=start, end=end, strict=strict
    )
    limits = _limits(recordings, before, max_speed, max_travel, max_current, max_torque)
    with status() as progress:
        found = plan(recordings, before, without=excluded, limits=limits, progress=progress)
    show_plan(found, before.motion)
    if found.proposal is not None:
        if output is not None:
            with new_file(output, force=force) as file:
                proposal = found.proposal
                file.write(write_command(proposal.command, proposal.seconds, proposal.why, before.motion))
        show_how(found.proposal, model, before, output, with_files or ())
    elif output is not None:
        say(f"\nThere is no command to propose, so {output} was not written.")
    warn_of(found.warnings, recordings)
    write_json(json, found.as_json())


def _limits(
    recordings: Sequence[Recording],
    model: Model,
    speed: float | None,
    travel: float | None,
    current: float | None,
    torque: float | None,
) -> Limits | None:
    """What the recordings have driven, with the given limits in its place; None if no limit is given."""
    from ..discovery.experiment.bench_limits import recorded_limits

    if speed is None and travel is None and current is None and torque is None:
        return None
    driven = recorded_limits(recordings, model)
    loads = _currents(driven, model, current, torque)
    return replace(
        driven,
        speed=driven.speed if speed is None else speed,
        lower=driven.lower if travel is None else -travel,
        upper=driven.upper if travel is None else travel,
        current=min(loads, default=driven.current),
    )


def _currents(driven: Limits, model: Model, current: float | None, torque: float | None) -> list[float]:
    """The given limits of current [A] and torque [N m or N], as currents [A].

    Raises InputError if the recordings, or the torque constant that is missing, give one of them no meaning.
    """
    from ema_bench_replay.errors import InputError

    from ..model.model_file import ABSENT, TORQUE_CONSTANT

    constant, (kind, _, unit) = driven.torque_constant, driven.load
    if torque is not None and constant is None:
        raise InputError("--max-torque: the recordings hold a current; give --max-current, in A")
    if current is not None and constant is not None and model.constants[TORQUE_CONSTANT].source == ABSENT:
        raise InputError(
            f"--max-current: the recordings hold no current but a {kind}, and model {model.name} has no torque "
            f"constant; give --max-torque, in {unit}"
        )
    return [
        *([] if current is None else [current]),
        *([] if torque is None or constant is None else [torque / constant]),
    ]

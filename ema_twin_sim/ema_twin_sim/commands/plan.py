"""``ema-twin plan``: the recording to make next."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..criteria import DECIDED
from ..listing import listed
from ..words.next_recording import rival_words, spoken
from ..words.sentences import dependence_words, effect_words
from . import options
from .output import console, say, status, unfolded
from .tables import ReportTable

if TYPE_CHECKING:
    from ema_bench_replay.recording import Recording

    from ..discovery.experiment.bench_limits import Limits
    from ..discovery.experiment.next_command import Proposal
    from ..discovery.plan import Plan
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
    from ema_bench_replay.outputs import new_file

    from ..discovery.plan import plan
    from ..simulation.command import write_command
    from .inputs import check_outputs, input_files, write_json
    from .judged import read_judged, warn_of

    check_outputs(input_files(runs, [model], import_map, with_files), force, command=output, json=json)
    recordings, (before,), excluded = read_judged(
        runs, [model], with_files, without, import_map=import_map, start=start, end=end, strict=strict
    )
    limits = _limits(recordings, before, max_speed, max_travel, max_current, max_torque)
    with status() as progress:
        found = plan(recordings, before, without=excluded, limits=limits, progress=progress)
    show(found, before.motion)
    if found.proposal is not None:
        if output is not None:
            with new_file(output, force=force) as file:
                proposal = found.proposal
                file.write(write_command(proposal.command, proposal.seconds, proposal.why, before.motion))
        _show_how(found.proposal, model, before, output, with_files or ())
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


def show(found: Plan, motion: str) -> None:
    """Print what is in doubt, the proposal with its runners-up, and what no command can distinguish."""
    from ..simulation.command import in_words

    if found.verdict == "unknown":
        on = f" (it depends on {dependence_words(found.depends_on)})" if found.depends_on else ""
        console.print(f"Part of the error fits no effect{on}; no command can be planned for it.\n")
    if not found.in_doubt and found.proposal is None:
        nothing = "" if found.verdict == "unknown" else ": these recordings show no missing effect"
        held = f": the model lacks {listed(map(effect_words, found.added))}" if found.added else nothing
        console.print(f"[bold]No doubt remains that another recording could resolve{held}.[/bold]", soft_wrap=True)
        return
    if found.in_doubt:
        console.print("[bold]In doubt[/bold]")
    else:
        console.print("[bold]No explanation is in doubt, but another recording would show more.[/bold]", soft_wrap=True)
    for doubt in found.in_doubt:
        unfolded(f"  {spoken(doubt.reason)}")
    proposal = found.proposal
    if proposal is not None:
        console.print(f"\n[bold]Record next: {proposal.command}[/bold] for {proposal.seconds:g} s", soft_wrap=True)
        unfolded(f"  {in_words(proposal.command, motion)}")
        unfolded(f"  {spoken(proposal.why)}")
        if proposal.beyond:
            load = "--max-current" if found.limits.torque_constant is None else "--max-torque"
            unfolded(
                f"  beyond what was recorded so far: {'; '.join(proposal.beyond)}. Make sure that the bench allows it"
                f" and nothing stops the output on the way, or give --max-speed, --max-travel or {load}."
            )
        if proposal.separation:
            console.print(_commands((proposal, *found.runners_up)))
        if proposal.shows:
            console.print(_shown(proposal))
        if proposal.hides:
            hides = listed(map(effect_words, proposal.hides), "or")
            unfolded(f"It would still not show {hides}: record it, then run plan again with it.")
    if found.inseparable:
        apart = "; ".join(" or ".join(map(rival_words, pair)) for pair in found.inseparable)
        unfolded(f"\nNo command within the limits can distinguish: {apart}.")
        for hint in found.elsewhere():
            unfolded(f"  {hint}")


def _commands(proposals: Sequence[Proposal]) -> ReportTable:
    table = ReportTable(f"\nHow well it would distinguish them, in standard deviations ({DECIDED:g} or more decide)")
    table.words("command")
    table.numbers("seconds", *(" or ".join(map(rival_words, pair)) for pair in proposals[0].separation))
    for k, proposal in enumerate(proposals):
        values = (f"{value:.0f}" if value >= 1.0 else "0" for value in proposal.separation.values())
        table.add_row(proposal.command, f"{proposal.seconds:g}", *values, style="bold" if k == 0 else "")
    return table


def _shown(proposal: Proposal) -> ReportTable:
    """Table of how clearly the proposal would show effects that are hidden so far."""
    table = ReportTable(
        f"\nHow clearly it would show effects of usual size, in standard errors ({DECIDED:g} or more decide)"
    )
    table.words("effect")
    table.numbers("so far", "with it")
    for id, (now, then) in proposal.shows.items():
        table.add_row(rival_words(id), f"{now:.1f}", f"{then:.0f}")
    return table


def _show_how(proposal: Proposal, name: str, model: Model, output: Path | None, with_files: Sequence[Path]) -> None:
    """Print how to run the command on the bench and on the virtual bench; ``name`` is how the model was given."""
    from ..simulation.simulate import has_speed_controller

    given = proposal.command if output is None else str(output)
    own = "".join(f" --with {quote(str(file))}" for file in with_files)
    ratio = model.value("machine.gear_ratio")
    at_motor = "" if model.is_direct else f" (of the motor: {ratio:g} times that)"
    unfolded(
        f"\nRun it on the bench, as the setpoint of the output{at_motor}, and give its recording to discover with the"
        " others."
    )
    if not has_speed_controller(model):
        unfolded(
            "The model has no speed controller and cannot simulate the command first: begin on the bench with a smaller"
            " one."
        )
        return
    unfolded("To simulate it with this model first:")
    run = f"--model {quote(name)} --command {quote(given)} --seconds {proposal.seconds:g}{own}"
    unfolded(f"  ema-twin simulate {run} -o next.mcap")

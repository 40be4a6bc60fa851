"""What ``ema-twin plan`` prints: what is in doubt, the command to record next, and how to run it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from shlex import quote

from ..criteria import DECIDED
from ..discovery.experiment.next_command import Proposal
from ..discovery.plan import Plan
from ..listing import listed
from ..model import Model
from ..simulation.command import in_words
from ..simulation.simulate import has_speed_controller
from ..words.next_recording import rival_words, spoken
from ..words.sentences import dependence_words, effect_words
from .output import console, unfolded
from .tables import ReportTable


def show_plan(found: Plan, motion: str) -> None:
    """Print what is in doubt, the proposal with its runners-up, and what no command can distinguish."""
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


def show_how(proposal: Proposal, name: str, model: Model, output: Path | None, with_files: Sequence[Path]) -> None:
    """Print how to run the command on the bench and on the virtual bench; ``name`` is how the model was given."""
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

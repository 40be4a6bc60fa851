"""What ``ema-twin live`` prints and writes when a run has ended."""

from __future__ import annotations

from ..comparison.beyond_noise import shown_signals
from ..live.no_bench import no_bench
from ..nodes.live_session import LiveResult
from ..quantities import quantity
from .output import console, say

_LATE, _LATE_BY = 1.05, 0.5
"""A run was late if it took more than this factor times its nominal duration, plus so many seconds."""


def as_json(result: LiveResult) -> dict[str, object]:
    """What ``compare --json`` writes, from the running nodes."""
    signals = dict(result.signals)
    return {
        "model": result.model,
        "input": result.input,
        "recordings": [
            {"name": result.name, "samples": result.samples, "duration": result.duration, "signals": signals}
        ],
        "overall": signals,
        "where": [],
        "warnings": list(result.warnings),
        "complete": result.complete,
        "counts": dict(result.counts),
        "elapsed": result.elapsed,
        **({} if result.health is None else {"health": result.health}),
        **({} if result.pace is None else {"twin_times_real_time": result.pace}),
    }


def how_much(result: LiveResult, *, loop: bool = False) -> str:
    """How many samples were compared, in words: whether any is missing, and whether the run was ended early.

    Each pass of a ``loop`` is compared by itself: the counts are those of the pass in which the run was ended.
    """
    compared, missing, expected = (result.counts[name] for name in ("compared", "missing", "expected"))
    if not compared and not expected:
        return "nothing was compared"
    count = f"{compared} of {expected} samples compared"
    if result.complete:
        return f"all {compared} samples compared" + (" in the last pass" if loop else "")
    if missing:
        return f"{count}, {missing} missing"
    return f"{count}, {'ended during this pass of the loop' if loop else 'stopped early'}, none missing"


def show(result: LiveResult, rate: float = 0.0, *, loop: bool = False) -> None:
    """Print the final result of the nodes, and whether the twin kept up with the replay ``rate`` (0: not checked)."""
    console.print(
        f"\n[bold]{result.name}[/bold], model {result.model}, live: {how_much(result, loop=loop)}, input {result.input}"
    )
    if not result.counts["expected"] and not result.counts["compared"]:
        say(no_bench(), style="yellow")
    if result.health is not None:
        say(f"Health of {result.health['unit']}: {result.health['words']}")
    for name in shown_signals(result.input, result.signals):
        signal = result.signals[name]
        rmse, floor = signal["rmse"], signal["noise_floor"]
        times = f"   {rmse / floor:8.1f} × noise" if floor > 0.0 else ""
        console.print(f"  {name.replace('_', ' '):<20} RMSE {quantity(rmse, signal['unit']):>12}{times}")
    if result.pace is None:
        return
    say(f"The twin computed at {result.pace:.2g} × real time.")
    if late := late_words(result, rate):
        say(late, style="yellow")


def late_words(result: LiveResult, rate: float) -> str:
    """A sentence if the twin is slower than real time, or than the requested ``rate``; otherwise empty."""
    if result.pace is not None and result.pace < 1.0:
        return (
            f"It cannot keep real time on this machine: {result.duration:.1f} s took {result.elapsed:.1f} s. Choose "
            f"drive.kind averaged or transmission.kind two_inertia for that, or play at --rate {0.9 * result.pace:.1g}."
        )
    if rate and result.elapsed > _LATE * result.duration / rate + _LATE_BY:
        wanted = result.duration / rate
        return f"The nodes could not keep the requested rate: {wanted:.1f} s of replay took {result.elapsed:.1f} s."
    return ""

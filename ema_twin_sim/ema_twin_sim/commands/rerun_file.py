"""Shared by the commands that write a rerun file: check its name, write it, and say how to open it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING

from ema_bench_replay.errors import InputError

from ..listing import listed
from .output import say

if TYPE_CHECKING:
    from ema_bench_replay.recording import Recording

    from ..comparison.compare import Comparison
    from ..model import Model
    from ..words.findings import Findings

MOST_MODELS = 3


def check_rrd_name(path: Path | None, models: int = 1) -> None:
    """Raise InputError if the name of a rerun file does not end in .rrd, or if there are more than three models."""
    if path is None:
        return
    if path.suffix != ".rrd":
        raise InputError(f"--rrd {path}: is not a rerun file's name; end it in .rrd")
    if models > MOST_MODELS:
        raise InputError(f"--rrd {path}: shows one to three models side by side; --model was given {models} times")


def write_rrd(
    path: Path,
    recordings: Sequence[Recording],
    models: Sequence[Model],
    labels: Sequence[str | Path],
    findings: Findings | None = None,
    *,
    source: str | None = None,
    step: float | None = None,
    comparisons: Sequence[Comparison] = (),
    names: Sequence[str] = (),
    force: bool = False,
) -> list[str]:
    """Write the views of recordings and models; return the names of the tabs.

    ``labels`` distinguish models of the same name. ``comparisons`` are given if they exist already; ``names`` replace
    the models' own names. Raises InputError if the file cannot be written.
    """
    from ..report.content import shown
    from ..views.recording_views import write_views
    from .report_page import told_apart

    given = shown(recordings, models, source, step=step, comparisons=comparisons)
    return write_views(path, given, models, names or told_apart(models, labels), findings, force=force)


def tell_of_rrd(path: Path, tabs: Sequence[str]) -> None:
    """Say what is in the file, and how to look at it."""
    from ..views.screen import why_not_shown

    reason = why_not_shown()
    where = f" on a machine with a display (here {reason})" if reason else ""
    say(f"\n{path} shows {listed(tabs)}. Open it{where}:")
    say(f"  rerun {quote(str(path))}")

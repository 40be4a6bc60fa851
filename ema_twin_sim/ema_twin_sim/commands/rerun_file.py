"""Shared by the commands that write a rerun file: write it, and say how to open it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from shlex import quote

from ema_bench_replay.recording import Recording

from ..comparison.compare import Comparison
from ..listing import listed
from ..model import Model
from ..report.content import shown
from ..views.recording_views import write_views
from ..views.screen import why_not_shown
from ..words.findings import Findings
from .output import say
from .report_page import told_apart


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
    given = shown(recordings, models, source, step=step, comparisons=comparisons)
    return write_views(path, given, models, names or told_apart(models, labels), findings, force=force)


def tell_of_rrd(path: Path, tabs: Sequence[str]) -> None:
    """Say what is in the file, and how to look at it."""
    reason = why_not_shown()
    where = f" on a machine with a display (here {reason})" if reason else ""
    say(f"\n{path} shows {listed(tabs)}. Open it{where}:")
    say(f"  rerun {quote(str(path))}")

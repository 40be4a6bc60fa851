"""All views of recordings with one to three models, as the tabs of one rerun file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import rerun.blueprint as rrb

from ..model import Model
from ..report.content import Shown
from ..report.residual_charts import failures
from ..report.where import sentences
from ..words.findings import Findings
from ..words.sentences import verdict_of
from .before_and_after import after_tab, log_after
from .beside_curves import curves_tab, log_curves
from .failing import failing_tab, log_failures
from .gear_train import log_train, send_motion, train_tab
from .stream import TIMELINE, new_rrd
from .train_motion import gearing_shown, train_motion
from .why import log_why, why_tab


def write_views(
    path: Path,
    given: Shown,
    models: Sequence[Model],
    names: Sequence[str],
    findings: Findings | None = None,
    *,
    force: bool = False,
) -> list[str]:
    """Write the views of recordings and models (one; before and after; or a fitted one too) as an .rrd.

    Returns the names of its tabs.
    Raises InputError if the file exists (without ``force``) or cannot be written.
    """
    found = failures(given, models[0], names)
    tabs: list[rrb.Container] = [curves_tab(given)]
    if found:
        tabs.append(failing_tab(found, len(models)))
    if findings is not None:
        tabs.append(why_tab(findings))
    if len(models) > 1:
        tabs.append(after_tab(given, names, findings))
    gearing, motion = gearing_shown(models[-1]), None
    if gearing is not None:
        played = given.recordings[given.telling]
        motion = train_motion(models[-1], gearing, played, given.input_of_all)
        if motion is not None:
            of = f"{names[-1]} beside {played.name}" if motion.simulated else f"as measured in {played.name}"
            tabs.append(train_tab(of, motion.strongest, gearing, simulated=motion.simulated))
    with new_rrd(path, layout(tabs), force=force) as stream:
        log_curves(stream, given, names)
        log_failures(stream, found, sentences(given), names)
        if findings is not None:
            log_why(stream, findings, verdict_of(findings, models[0].name))
        if len(models) > 1:
            log_after(stream, given, names, findings)
        if gearing is not None and motion is not None:
            log_train(stream, gearing)
            send_motion(stream, gearing, motion, motion.strongest)
    return [str(tab.name) for tab in tabs]


def layout(tabs: Sequence[rrb.Container], timeline: str = TIMELINE) -> rrb.Blueprint:
    """Tabs over the whole window, with the panels around them closed, and time as it was recorded."""
    return rrb.Blueprint(
        rrb.Tabs(*tabs, active_tab=0),
        rrb.TimePanel(state="collapsed", timeline=timeline),
        auto_views=False,
        collapse_panels=True,
    )

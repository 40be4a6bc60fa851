"""Shared by the commands that write a report page: what was found, the page, and the names of the models in it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from ema_bench_replay.errors import InputError
from ema_bench_replay.outputs import write_text
from ema_bench_replay.recording import Recording

from ..comparison.compare import Comparison
from ..discovery.diagnose import weigh
from ..discovery.discover import Discovery, discover
from ..model import Model
from ..report.backwards import backwards
from ..report.content import Content, shown
from ..report.difference import two_values
from ..report.page import page
from ..report.summary import misread
from ..version import VERSION
from ..words.findings import Findings, findings_of
from ..words.fit_findings import FitFindings


def write_page(
    output: Path,
    recordings: Sequence[Recording],
    models: Sequence[Model],
    labels: Sequence[str | Path],
    findings: Findings | None,
    *,
    fit: FitFindings | None = None,
    comparisons: Sequence[Comparison] = (),
    held_out: Sequence[Recording] = (),
    source: str | None = None,
    story: str = "",
    undiagnosed: str = "",
    force: bool = False,
) -> list[str]:
    """Compare two or three models with the recordings and write the page.

    ``labels`` distinguish models of the same name. A third model is left out if none of its numbers differs from the
    second's by more than its standard error. ``comparisons`` are those of all these models, if they exist already.
    Returns what puts the page in doubt, and its remarks on the models. Raises InputError if a recording lacks the
    input's signal, or if the page cannot be written.
    """
    names, note = told_apart(models, labels), ""
    if len(models) > 2 and not fitting_moved(models, findings, fit):
        note = f"{names[2]} is not shown: no parameter differs from {names[1]}'s by more than its standard error."
        models, names, comparisons = models[:2], names[:2], comparisons[:2]
    given = shown(recordings, models, source, comparisons=comparisons)
    apart = shown(held_out, models, source) if held_out else None
    content = Content(tuple(models), names, given, apart, findings, VERSION, story, undiagnosed, fit, note)
    write_text(output, page(content), force=force)
    return [*misread(content), *(text for text in (backwards(content), note) if text)]


def fitting_moved(models: Sequence[Model], findings: Findings | None, fit: FitFindings | None) -> bool:
    """Whether any number of the third model differs from the second's by more than its standard error."""
    return any(each.differ for each in two_values(models[1], models[2], findings, fit))


def told_apart(models: Sequence[Model], labels: Sequence[str | Path]) -> tuple[str, ...]:
    """The models' names; if some are equal, the names of their files."""
    for names in ([model.name for model in models], [Path(label).stem for label in labels]):
        if len(set(names)) == len(names):
            return tuple(names)
    return tuple(map(str, labels))


def weighed(found: Discovery) -> Findings:
    """Findings of a finished search, with the probabilities of its diagnosis."""
    return findings_of(found, weigh(found))


def searched(
    recordings: list[Recording], model: Model, progress: Callable[[str], None]
) -> tuple[Findings | None, str, list[Recording]]:
    """Findings of a search, and the recordings as it took them; or None, and the reason why they cannot be judged."""
    try:
        found = discover(recordings, model, progress=progress)
    except InputError as refused:
        return None, f"no diagnosis: {refused}", recordings
    progress("computing probabilities")
    return weighed(found), "", list(found.given)

"""Shared by the commands that write a report page: check its name, write it, and name the models in it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ema_bench_replay.errors import InputError
from ema_bench_replay.outputs import write_text

if TYPE_CHECKING:
    from ema_bench_replay.recording import Recording

    from ..comparison.compare import Comparison
    from ..discovery.discover import Discovery
    from ..model import Model
    from ..words.findings import Findings
    from ..words.fit_findings import FitFindings


def check_page_name(path: Path | None) -> None:
    """Raise InputError if the name of a report does not end in .html or .htm."""
    if path is not None and path.suffix.lower() not in (".html", ".htm"):
        raise InputError(f"{path}: a report is a page; name it .html")


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
    from ..report.backwards import backwards
    from ..report.content import Content, shown
    from ..report.page import page
    from ..report.summary import misread
    from ..version import VERSION

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
    from ..report.difference import two_values

    return any(each.differ for each in two_values(models[1], models[2], findings, fit))


def told_apart(models: Sequence[Model], labels: Sequence[str | Path]) -> tuple[str, ...]:
    """The models' names; if some are equal, the names of their files."""
    for names in ([model.name for model in models], [Path(label).stem for label in labels]):
        if len(set(names)) == len(names):
            return tuple(names)
    return tuple(map(str, labels))


def weighed(found: Discovery) -> Findings:
    """Findings of a finished search, with the probabilities of its diagnosis."""
    from ..discovery.diagnose import weigh
    from ..words.findings import findings_of

    return findings_of(found, weigh(found))

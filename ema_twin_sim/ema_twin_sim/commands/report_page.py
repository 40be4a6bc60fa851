"""What the commands share that write the page of a report: its name, its content, what it doubts of the models."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ema_bench_replay.errors import InputError

if TYPE_CHECKING:
    from ema_bench_replay.recording import Recording

    from ..comparison.compare import Comparison
    from ..discovery.discover import Discovery
    from ..model import Model
    from ..words.findings import Findings
    from ..words.fit_findings import FitFindings


def check_page_name(path: Path | None) -> None:
    """Raise InputError where the name of a report does not tell what it is."""
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
    """Compare two or three models with the recordings, and write the page; ``labels`` tell models of one name apart.

    A third model is left out where it differs from the second by no more than standard errors. ``comparisons`` are of
    all these models, where they were made already. Returns what the page doubts of the models. Raises InputError where
    a recording lacks the input's signal, or where the page cannot be written.
    """
    from ..report.backwards import backwards
    from ..report.content import Content, shown
    from ..report.page import write_report
    from ..version import VERSION

    names, note = told_apart(models, labels), ""
    if len(models) > 2 and not fitting_moved(models, findings, fit):
        note = f"{names[2]} is not shown: none of its numbers is farther from {names[1]}'s than its standard error."
        models, names, comparisons = models[:2], names[:2], comparisons[:2]
    given = shown(recordings, models, source, comparisons=comparisons)
    apart = shown(held_out, models, source) if held_out else None
    content = Content(tuple(models), names, given, apart, findings, VERSION, story, undiagnosed, fit, note)
    write_report(output, content, force=force)
    return [text for text in (backwards(content), note) if text]


def fitting_moved(models: Sequence[Model], findings: Findings | None, fit: FitFindings | None) -> bool:
    """Whether a number of the third model is farther from the second's than its standard error."""
    from ..report.fitted import two_values

    return any(each.differ for each in two_values(models[1], models[2], findings, fit))


def told_apart(models: Sequence[Model], labels: Sequence[str | Path]) -> tuple[str, ...]:
    """The models' names; where some are the same, those of their files."""
    for names in ([model.name for model in models], [Path(label).stem for label in labels]):
        if len(set(names)) == len(names):
            return tuple(names)
    return tuple(map(str, labels))


def weighed(found: Discovery) -> Findings:
    """The findings of a search that was made, with what its diagnosis weighs."""
    from ..discovery.diagnose import weigh
    from ..words.findings import findings_of

    return findings_of(found, weigh(found))

"""The page: all sections in one self-contained HTML file, which loads nothing else."""

from __future__ import annotations

from ..words.next_recording import recording_words
from .chart import Charts
from .compared import compared
from .content import Content
from .markup import Markup, capitalised, joined, section, tag
from .ranking import diagnosis
from .recordings import held_out, recordings
from .steps import steps
from .summary import head, verdict
from .where import where
from .whole_page import whole_page


def page(content: Content) -> str:
    """The whole page."""
    charts = Charts()
    sections = [
        compared(content, charts),
        where(content, charts),
        diagnosis(content, charts),
        steps(content, charts),
        recordings(content),
        held_out(content),
        _next(content),
    ]
    return whole_page(verdict(content), joined([head(content), _contents(), *sections]), charts=charts)


_SECTIONS = {
    "compare": "measured against twin",
    "where": "where the models fail",
    "diagnosis": "diagnosis",
    "steps": "steps and numbers",
    "recordings": "recording by recording",
    "held-out": "held out",
    "next": "record next",
}


def _contents() -> Markup:
    return tag("nav", *(tag("a", title, href=f"#{id}") for id, title in _SECTIONS.items()), aria_label="Sections")


def _next(content: Content) -> Markup:
    """The section on what to record next, with the warnings about recordings and models."""
    findings = content.findings
    of_models = (text for each in content.given.comparisons[1:] for text in each.warnings)
    warnings = dict.fromkeys((*of_models, *(findings.warnings if findings else ())))
    told = [tag("p", "Warning: ", text, class_="warning") for text in warnings]
    if findings is None:
        line = content.undiagnosed or "No recommendation: no search was made."
    else:
        suggested = recording_words(findings.next_recording, content.models[0].motion)
        if suggested != findings.next_recording:  # a command, which is written in small letters
            suggested = f"Record {suggested}"
        line = suggested or "No doubt remains that another recording could resolve."
    return section("next", "What to record next", tag("p", capitalised(line)), *told)

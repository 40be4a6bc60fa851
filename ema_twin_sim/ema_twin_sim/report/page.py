"""The page: all sections in one self-contained HTML file, which loads nothing from anywhere."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from plotly.offline import get_plotlyjs

from ema_bench_replay.outputs import new_file

from .chart import Charts
from .compared import compared
from .content import Content
from .markup import Markup, section, tag
from .ranking import diagnosis
from .recordings import held_out, recordings
from .steps import steps
from .summary import head, verdict
from .where import where

_POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"
"""What a browser may load for the page: nothing. What a reader saves of a plot is made in the page itself."""


def write_report(path: Path, content: Content, *, force: bool = False) -> None:
    """Write the report. Raises InputError where the file exists (without ``force``) or cannot be written."""
    text = page(content)
    with new_file(path, force=force) as file:
        file.write(text.encode())


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
    body = [head(content), _contents(), *sections]
    title = tag("title", verdict(content))
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<meta name="color-scheme" content="light dark"><meta name="generator" content="ema-twin">{title}'
        f"<style>{_part('page.css')}</style></head><body><main>{''.join(body)}</main>"
        f"<script>{get_plotlyjs()}</script>"
        f'<script type="application/json" id="charts">{charts.as_json()}</script>'
        f"<script>{_part('page.js')}</script></body></html>\n"
    )


def _part(name: str) -> str:
    return files(__package__).joinpath(name).read_text(encoding="utf-8")


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
    """What to record next, and what the machine's reader should know of the recordings."""
    findings = content.findings
    of_models = (text for each in content.given.comparisons[1:] for text in each.warnings)
    warnings = dict.fromkeys((*of_models, *(findings.warnings if findings else ())))
    told = [tag("p", "Warning: ", text, class_="warning") for text in warnings]
    if findings is None:
        line = content.undiagnosed or "Not told: no search was made."
    else:
        line = findings.next_recording or "Nothing is in doubt that another recording would settle."
    return section("next", "What to record next", tag("p", f"{line[:1].upper()}{line[1:]}"), *told)

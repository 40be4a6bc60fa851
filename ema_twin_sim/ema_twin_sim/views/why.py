"""Why: the ranked effects that may be missing, how well their parameters are known, and the signature of each."""

from __future__ import annotations

import rerun as rr
import rerun.blueprint as rrb

from ..quantities import estimate
from ..report.ranking import REFUSED, signature_chart, told_signatures
from ..words.findings import Findings, Signature
from ..words.parameters import numbers_of
from ..words.ranking import other_answers, ranked_words, worth_showing
from ..words.sentences import effect_words, removed_words
from .drawn_bars import Bar, bars_view, draw_bars
from .drawn_chart import draw
from .palette import AFTER, FAINT
from .sheet import linear_axis, sheet_view

ROOT = "why"
_LONG = 90  # letters; a longer verdict takes a second line, so its heading is smaller
_IN_A_ROW = 3  # signatures in a row
_EXPLAINED = {"torque": "residual torque", "encoder_difference": "residual encoder difference"}


def log_why(stream: rr.RecordingStream, findings: Findings, verdict: str) -> None:
    """Draw the ranking, the standard errors of the parameters and each signature; write the verdict."""
    if findings.ranking:
        draw_bars(stream, f"{ROOT}/ranking", _ranking(findings), linear_axis(0.0, 100.0, "probability [%]"),
                  "blue: found;  grey: rejected;  removes: share of the error")  # fmt: skip
    sizes = _sizes(findings)
    if sizes:
        draw_bars(stream, f"{ROOT}/sizes", sizes, linear_axis(0.0, 200.0, "% of the value that was found"),
                  "white: ± one standard error")  # fmt: skip
    for number, signature in enumerate(told_signatures(findings)):
        draw(stream, f"{ROOT}/signature_{number}", signature_chart(signature)).done()
    heading = "##" if len(verdict) < _LONG else "###"
    stream.log(
        f"{ROOT}/verdict", rr.TextDocument(f"{heading} {verdict}", media_type=rr.MediaType.MARKDOWN), static=True
    )


def _ranking(findings: Findings) -> list[Bar]:
    bars = []
    for entry in worth_showing(findings.ranking)[0]:
        text = f"{100.0 * entry.probability:.0f} %"
        if entry.error_removed is not None:
            removed = removed_words(entry.error_removed)
            text += f", removes {removed}"
        bars.append(Bar(ranked_words(entry), 100.0 * entry.probability, text, AFTER if entry.found else FAINT))
    bars += [Bar(name, 100.0 * share, f"{100.0 * share:.0f} %", FAINT) for name, share in other_answers(findings)]
    return bars


def _sizes(findings: Findings) -> list[Bar]:
    """Bars of the found effects' parameters, each as 100 % of its value."""
    bars = []
    for name, entry in (findings.parameters or {}).items():
        for parameter, held in numbers_of(entry).items():
            if held["std"] is None or not held["value"]:
                continue
            text = estimate(held["value"], held["std"], held["unit"])
            relative = 100.0 * held["std"] / abs(held["value"])
            title = f"{effect_words(name)}, {parameter.replace('_', ' ')}"
            bars.append(Bar(title, 100.0, f"{text} ({relative:.1f} %)", AFTER, relative))
    return bars


def _title(signature: Signature) -> str:
    effects = effect_words(signature.title)
    refused = "" if signature.taken else f" ({REFUSED})"
    return f"{effects}{refused}: the {_EXPLAINED.get(signature.left_over, signature.left_over)} that it explains"


def why_tab(findings: Findings) -> rrb.Container:
    """The verdict on top, the bars below it, and below them the signatures."""
    bars = []
    if findings.ranking:
        bars.append(bars_view(f"{ROOT}/ranking", "which effect is missing: probabilities", len(_ranking(findings))))
    if sizes := _sizes(findings):
        bars.append(bars_view(f"{ROOT}/sizes", "the numbers that were found, with their standard errors", len(sizes)))
    signatures = [
        sheet_view(f"{ROOT}/signature_{number}", _title(signature))
        for number, signature in enumerate(told_signatures(findings))
    ]
    rows: list[rrb.Container] = [rrb.Horizontal(*bars)] if bars else []
    pages = [
        rrb.Horizontal(*signatures[k : k + _IN_A_ROW], name=f"signatures from {k + 1}")
        for k in range(0, len(signatures), _IN_A_ROW)
    ]
    if pages:
        rows.append(rrb.Tabs(*pages, active_tab=0) if len(pages) > 1 else pages[0])
    verdict = rrb.TextDocumentView(origin=f"{ROOT}/verdict", name="verdict")
    return rrb.Vertical(verdict, *rows, row_shares=[1.5, *[4] * len(rows)], name="why")

"""The diagnosis: ranked effects with their probabilities, runners-up, and effects that the data cannot tell apart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..listing import listed
from ..quantities import axis_unit, signal_words
from ..words.findings import CURVES, Findings, Signature
from ..words.ranking import UNLIKELY, other_answers, ranked_words, size_words, worth_showing
from ..words.sentences import (
    effect_words,
    groups_sentence,
    removed_words,
    surest_sentence,
    verdict_of,
)
from .backwards import searched_model
from .chart import AFTER, BEFORE, RIVAL, Chart, Charts, Trace, axis, band, line
from .content import Content
from .markup import Markup, bar, capitalised, section, swatch, table, tag

REFUSED = "closest to the remaining error, but the search did not add it"
"""Caption of the signature of an effect that the search tried last and did not add."""
_HEIGHT = 300  # pixels
_HEADROOM = 1.4  # limit of the axis, times the largest median
_QUANTITIES = {
    "torque": "residual torque of the model",
    "encoder_difference": "residual encoder difference of the model",
}


def diagnosis(content: Content, charts: Charts) -> Markup:
    """The section of the diagnosis."""
    findings = content.findings
    model = searched_model(content)
    title = f"What {model} lacks: the diagnosis"
    if findings is None:
        return section("diagnosis", title, tag("p", content.undiagnosed or "No search was made."))
    parts = [tag("p", verdict_of(findings, model), class_="lead")]
    if findings.ranking:
        parts.append(_ranking(findings))
    if findings.groups:
        parts.append(tag("p", groups_sentence(findings.groups)))
    parts.append(_tried(findings))
    figures = [charts.add(signature_chart(signature)) for signature in told_signatures(findings)]
    if figures:
        said = {"before": "without it", "after": "with it", "rival": "with the runner-up"}
        key = tag("p", *(swatch(role, name) for role, name in said.items()), class_="key")
        parts += [tag("h3", "The signature that each effect explains"), key, tag("div", *figures, class_="grid")]
    return section("diagnosis", title, *parts)


def told_signatures(findings: Findings) -> list[Signature]:
    """The signatures of the effects that were found; those of refused ones only if the verdict is ``unknown``."""
    wanted = findings.verdict == "unknown"
    return [each for each in findings.signatures if each.curves and (each.taken or wanted)]


def _ranking(findings: Findings) -> Markup:
    rows = []
    for entry in worth_showing(findings.ranking)[0]:
        name, kind = ranked_words(entry), "found" if entry.found else "refused"
        removed = (
            "–" if entry.error_removed is None else bar(entry.error_removed, removed_words(entry.error_removed), kind)
        )
        rows.append(
            (
                tag("strong", name) if entry.found else name,
                bar(entry.probability, f"{100.0 * entry.probability:.0f} %", kind),
                removed,
                ", ".join(size_words(entry)),
            )
        )
    for said, probability in other_answers(findings):
        rows.append((said, bar(probability, f"{100.0 * probability:.0f} %", "refused"), "", ""))
    note = (
        "Probability: that this effect is missing; several may be missing at once, and those that the recordings "
        f"cannot tell apart share one. {surest_sentence()} "
        "Error removed: share of the error above the sensors' noise that it removes, on data not used for fitting. "
        "± is one standard error."
    )
    head = ("effect", "probability", "error removed", "size")
    return _with_note(table(head, rows, words=range(4)), note)


def _with_note(whole: Markup, note: str) -> Markup:
    """A table and the note below it."""
    return tag("div", whole, tag("p", note, class_="aside"))


def _tried(findings: Findings) -> Markup:
    """Table of what each step of the search tried."""
    rows: list[tuple[str, ...]] = []
    for step in findings.steps:
        if step.action != "add":
            continue
        tried: Sequence[Mapping[str, Any]] = step.tried
        took = next((trial for trial in tried if step.instance in trial["names"]), None)
        if took is None or not took["gain"] > 0.0:
            continue
        best = sorted(tried, key=lambda trial: float(trial["gain"]))  # the best of equal names comes last
        others = {_named(trial): trial for trial in best if step.instance not in trial["names"]}
        rivals = sorted(others.values(), key=lambda trial: -float(trial["gain"]))
        for trial in (took, *rivals[:UNLIKELY]):
            share = max(0.0, trial["gain"] / took["gain"])
            said = f"{100.0 * share:.0f} %" if share >= 0.01 or share == 0.0 else "below 1 %"
            name = _named(trial)
            place = f"{effect_words(step.instance)}" if trial is took else ""
            rows.append(
                (
                    place,
                    tag("strong", name) if trial is took else name,
                    bar(share, said, "found" if trial is took else "refused"),
                )
            )
    if not rows:
        return Markup()
    return _with_note(
        table(
            ("step", "tried", "gain, relative to the best"),
            rows,
            words=range(3),
            caption="Runners-up: what was tried in each step",
        ),
        "Gain: the reduction of the misfit to torque and encoders, minus a penalty per added parameter.",
    )


def _named(trial: Mapping[str, Any]) -> str:
    return listed(effect_words(name) for name in trial["names"])


def signature_chart(signature: Signature) -> Chart:
    """Residuals without an effect, with it, and with its runner-up, against the quantity that shows it best."""
    size = max((abs(v) for curve in signature.curves for v in curve["median"]), default=0.0)
    scale, unit = axis_unit(size, signature.unit)
    roles = dict(zip(CURVES, (BEFORE, AFTER, RIVAL), strict=True))
    names = "without it", f"with {_plain(signature.title)}", f"with {_plain(signature.runner_up)}"
    said = dict(zip(CURVES, names, strict=True))
    traces: list[Trace] = []
    for curve in signature.curves:
        x, (lower, median, upper) = (
            np.array(curve["x"]),
            (np.array(curve[q]) / scale for q in ("lower", "median", "upper")),
        )
        role, name = roles[curve["name"]], said[curve["name"]]
        rival = curve["name"] == "runner_up"
        traces += [] if rival else band(x, lower, upper, name, role)
        dash = "dot" if curve["direction"] == "backward" else "solid"
        traces.append(line(x, median, name, role, width=1.5 if rival else 2.5, dash=dash))
    against = signal_words(signature.against, signature.against_unit) + (
        f", folded at order {signature.order:g}" if signature.order is not None else ""
    )
    refused = "" if signature.taken else f" ({REFUSED})"
    other = f"; runner-up: {_plain(signature.runner_up)}" if signature.runner_up else ""
    ways = (
        " Forward solid, backward dotted."
        if any(curve["direction"] == "backward" for curve in signature.curves)
        else ""
    )
    title = _plain(signature.title)
    left_over = signal_words(_QUANTITIES.get(signature.left_over, signature.left_over), signature.unit)
    caption = f"{capitalised(title)}{refused}: {left_over}, against {against}{other}.{ways}"
    layout = {
        "xaxis": axis(f"{against} [{signature.against_unit}]"),
        "yaxis": axis(f"residual [{unit}]", range=[-_HEADROOM * size / scale, _HEADROOM * size / scale]),
    }
    return Chart(caption, _HEIGHT, layout, traces)


def _plain(title: str) -> str:
    """A title with its effect ids replaced by words."""
    return " and ".join(effect_words(part) for part in title.split(" and "))

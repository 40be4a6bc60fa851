"""The steps of the search: the error after each step, parameters with standard errors, and constants that moved."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby, pairwise
from typing import Any

import numpy as np

from ..comparison.running_comparison import share_removed
from ..listing import listed
from ..quantities import axis_unit, estimate, quantity, signal_words
from ..words.findings import Findings, Held, UnseenErrors
from ..words.parameters import parameter_rows
from ..words.sentences import (
    REFIT,
    REFIT_IS,
    change_words,
    draft_words,
    effect_words,
    is_visible,
    larger_sentence,
    output_sentence,
    removed_words,
    why_step,
)
from .chart import AFTER, FAINT, Chart, Charts, axis, label, line, log_axis
from .content import Content
from .difference import NewEffect, TwoValues, apart, two_values
from .markup import Markup, section, table, tag

_HEIGHT = 340  # pixels


def steps(content: Content, charts: Charts) -> Markup:
    """The section of the steps and of the resulting numbers."""
    findings = content.findings
    parts: list[Markup] = []
    if findings is not None and findings.steps:
        rows = [
            (
                f"{'+' if step.action == 'add' else '−'} {effect_words(step.instance)}",
                quantity(step.rmse_before, step.unit),
                quantity(step.rmse_after, step.unit),
                removed_words(step.error_removed, step.rmse_before, step.rmse_after),
                *(quantity(value, "rad") for value in (step.output_before, step.output_after)),
                why_step(step),
            )
            for step in findings.steps
        ]
        errors = ("RMSE before", "RMSE after", "excess removed", "output before", "output after")
        head = ("step", *errors, "runner-up, or reason")
        parts.append(table(head, [*_refit(findings), *rows], words=(0, 6)))
        if grew := larger_sentence(findings.steps, findings.unseen):
            parts.append(tag("p", grew, class_="aside"))
    if findings is not None and findings.unseen is not None and len(findings.unseen.rmse) > 1:
        parts.append(charts.add(falling(findings, findings.unseen)))
    return section("steps", "Step by step, and the numbers", *parts, *_parameters(content), *_constants(content))


def _refit(findings: Findings) -> list[tuple[str, ...]]:
    """The row for fitting the model's own constants before any effect was added; empty if that changed nothing."""
    unseen = findings.unseen
    if unseen is None or unseen.given is None or unseen.given == unseen.rmse[0]:
        return []
    share = share_removed(unseen.given, unseen.rmse[0], unseen.noise_floor)
    sizes = draft_words(unseen.given, unseen.rmse[0], unseen.unit), quantity(unseen.rmse[0], unseen.unit)
    return [(REFIT, *sizes, removed_words(share, unseen.given, unseen.rmse[0]), "–", "–", REFIT_IS)]


def falling(findings: Findings, unseen: UnseenErrors) -> Chart:
    """RMSE after each step, for all recordings together and for each recording."""
    whole, each = from_the_given(unseen)
    scale, unit = axis_unit(max(whole), unseen.unit)
    places = _places(findings, len(unseen.rmse))
    if len(whole) > len(unseen.rmse):
        places = ["unchanged", REFIT, *places[1:]]
    at = np.arange(len(places))
    traces = [line(at, np.array(values) / scale, name, FAINT, width=1.2, **_points(5, FAINT)) for name, values in each]
    traces.append(line(at, np.array(whole) / scale, "all recordings", AFTER, width=3.5, **_points(10, AFTER)))
    floor = unseen.noise_floor / scale
    shown = [value / scale for values in (whole, *(values for _, values in each)) for value in values]
    across = {"type": "line", "xref": "x domain", "x0": 0, "x1": 1}
    noise = {**across, "y0": floor, "y1": floor, "line": {"color": FAINT, "dash": "dash"}}
    above = {"y": float(np.log10(floor)) if floor > 0.0 else 0, "yanchor": "bottom"}
    told = {"text": "the sensors' noise", "xref": "x domain", "x": 0, "xanchor": "left", **above, "showarrow": False}
    judged = (
        "each with numbers fitted to the others" if len(unseen.recordings) > 1 else "to which the numbers were fitted"
    )
    caption = (
        f"RMSE of the {signal_words(unseen.signal, unseen.unit)} after each step: all recordings (thick) and each "
        f"(thin), {judged}"
    )
    layout = {
        "xaxis": axis("step", tickvals=[*range(len(at))], ticktext=places, range=[-0.4, len(at) - 0.6]),
        "yaxis": log_axis(f"RMSE [{unit}]", np.array([*shown, floor])),
        "shapes": [noise],
        "annotations": [told],
    }
    return Chart(caption, _HEIGHT, layout, traces, wide=True)


def _points(size: int, colour: str) -> dict[str, Any]:
    """Style of a curve that shows its points."""
    return {"mode": "lines+markers", "marker": {"size": size, "color": colour}}


def from_the_given(unseen: UnseenErrors) -> tuple[tuple[float, ...], list[tuple[str, tuple[float, ...]]]]:
    """(pooled, by recording) RMSE after each step; starts with the unchanged model if its constants were fitted."""
    if unseen.given is None or unseen.given == unseen.rmse[0]:
        return unseen.rmse, list(unseen.recordings)
    pairs = zip(unseen.given_recordings, unseen.recordings, strict=True)
    return (unseen.given, *unseen.rmse), [(name, (given, *values)) for given, (name, values) in pairs]


def _places(findings: Findings, count: int) -> list[str]:
    """Labels of the steps: the start, each round (whose steps have the same errors), and the end."""
    rounds = [
        "<br>".join(f"{'+' if step.action == 'add' else '−'} {label(effect_words(step.instance))}" for step in together)
        for _, together in groupby(findings.steps, key=lambda step: (step.rmse_before, step.rmse_after))
    ]
    places = ["start", *rounds][:count]
    places += ["refitted" if k == count - 1 else f"round {k}" for k in range(len(places), count)]
    return places


def _parameters(content: Content) -> list[Markup]:
    """Tables of the parameters of the effects that were added, and of those that the later model lacks."""
    before, after = content.names[:2]
    came = content.new
    fitted = len(content.models) > 2
    caption = f"Parameters of the effects that only {after} has"
    if fitted:
        caption = "Parameters of the effects found, before and after the fit; ± is one standard error"
    told = _of_effects(came, content, caption, fitted=fitted)
    if sentence := output_sentence(content.models[1], [effect.name for effect in came]):
        told = [*told, tag("p", sentence, class_="aside")]
    return [*told, *_of_effects(content.gone, content, f"Parameters of the effects that only {before} has")]


def _of_effects(effects: Sequence[NewEffect], content: Content, caption: str, *, fitted: bool = False) -> list[Markup]:
    """The parameters of effects: as they are, or as they were found and as they were ``fitted``."""
    both = {each.path: each for each in content.fitted_numbers}
    rows = []
    cells: tuple[str, ...]
    for effect in effects:
        for first, name, held in parameter_rows(effect.name, effect.options, effect.parameters):
            if fitted:
                moved = both.get(f"{effect.name}.{name}")
                cells = ("the same", "") if moved is None else (_estimate(moved.after), _moved(moved))
            else:
                known = held["std"] and held["value"]
                cells = (f"{100.0 * held['std'] / abs(held['value']):.1f} %" if known else "–",)
            rows.append((*first, name, _estimate(held), *cells))
    if not rows:
        return []
    columns = (*content.labels[1:], "moved by fitting") if fitted else ("value ± standard error", "relative error")
    return [table(("effect", "options", "parameter", *columns), rows, words=range(3), caption=caption)]


def _estimate(held: Held) -> str:
    return estimate(held["value"], held["std"], held["unit"])


def _moved(both: TwoValues) -> str:
    if not is_visible(both.before["value"], both.after["value"]):
        return ""
    moved = change_words({**both.after, "nominal": both.before["value"]})
    return moved if both.differ else f"{moved}, within its standard error".removeprefix(", ")


def _constants(content: Content) -> list[Markup]:
    """The constants that moved: those by more than their standard error in a table, the others in one line."""
    rows, slightly = [], []
    for path, values in _moved_constants(content).items():
        part, _, constant = path.partition(".")
        name = f"{effect_words(part)}: {constant.replace('_', ' ')}"
        change = change_words({**values[-1], "nominal": values[0]["value"]})
        if any(apart(a, b) and is_visible(a["value"], b["value"]) for a, b in pairwise(values)):
            rows.append((name, *map(_estimate, values), change))
        elif is_visible(values[0]["value"], values[-1]["value"]):
            slightly.append(f"{name} {change}")
    caption = "Constants that moved"
    parts = [table(("constant", *content.labels, "change"), rows, caption=caption)] if rows else []
    if slightly:
        told = f"Moved within standard errors: {listed(slightly)}."
        parts.append(tag("p", told, class_="aside"))
    return parts


def _moved_constants(content: Content) -> dict[str, list[Held]]:
    """By path: the values, in all models, of the numbers that the first model has too and a later one changed."""
    came = {effect.name for effect in content.new}
    found = {each.path: each for each in two_values(*content.before_and_after, None, content.findings)}
    fitted = {each.path: each for each in content.fitted_numbers if each.part not in came}
    moved: dict[str, list[Held]] = {}
    for path in dict.fromkeys((*found, *fitted)):
        second = found[path].after if path in found else fitted[path].before
        first = found[path].before if path in found else {**second, "std": None}
        moved[path] = [first, second]
        if len(content.models) > 2:
            moved[path].append(fitted[path].after if path in fitted else second)
    return moved

"""After: how much each step of the discovery reduced the error, and all models' errors in times the sensors' noise."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import groupby

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from ..listing import listed
from ..quantities import axis_unit, quantity, signal_words
from ..report.content import Shown
from ..report.steps import falling
from ..words.findings import Findings
from ..words.sentences import effect_words
from .drawn_bars import Bar, bars_view, draw_bars
from .drawn_chart import draw
from .palette import AFTER, MODELS
from .sheet import Sheet, linear_axis, log_axis, named_axis, sheet_view

ROOT = "after"
_COLOURS = ("orange", "blue", "pink")


def log_after(stream: rr.RecordingStream, given: Shown, names: Sequence[str], findings: Findings | None) -> None:
    """Draw all models' errors and, if a search was made, how they fell step by step."""
    bars = _errors(given, names)
    highest = max([10.0, *(bar.value for bar in bars)])
    axis = log_axis(0.5, 1.2 * highest, "RMSE / sensors' noise (1 is the best possible)")
    heading = listed(f"{name} ({colour})" for name, colour in zip(names, _COLOURS, strict=False))
    draw_bars(stream, f"{ROOT}/errors", bars, axis, heading)
    if findings is not None and findings.unseen is not None and len(findings.unseen.rmse) > 1:
        draw(stream, f"{ROOT}/falling", falling(findings, findings.unseen)).done()
    if findings is not None and len(outputs := _outputs(findings)) > 1:
        _log_outputs(stream, outputs)


def _errors(given: Shown, names: Sequence[str]) -> list[Bar]:
    bars = []
    for name in given.signals:
        for number, (model, comparison) in enumerate(zip(names, given.comparisons, strict=True)):
            error = comparison.overall[name]
            if error["noise_floor"] > 0.0:
                times = error["rmse"] / error["noise_floor"]
                text = f"{quantity(error['rmse'], error['unit'])}, {times:.3g} × noise"
                label = given.words(name) if number == len(names) // 2 else ""
                bars.append(Bar(f"{given.words(name)}, {model}", times, text, MODELS[number], label=label))
    return bars


def _outputs(findings: Findings) -> list[tuple[str, float]]:
    """The error of the output's position [rad] at the start and after each round of the search."""
    added = [step for step in findings.steps if step.output_before is not None and step.output_after is not None]
    found: list[tuple[str, float]] = []
    for (before, after), together in groupby(added, key=lambda step: (step.output_before, step.output_after)):
        steps = ", ".join(f"{'+' if s.action == 'add' else '−'} {effect_words(s.instance)}" for s in together)
        found = found or [("start", float(before or 0.0))]
        found.append((steps, float(after or 0.0)))
    return found


def _log_outputs(stream: rr.RecordingStream, outputs: Sequence[tuple[str, float]]) -> None:
    errors = np.array([error for _, error in outputs])
    scale, unit = axis_unit(float(errors.max()), "rad")
    x = named_axis([name for name, _ in outputs], "step")
    positive = errors[errors > 0.0] / scale
    title = f"RMSE of the output's position [{unit}, slow shaft]"
    low, high = (float(positive.min()), float(positive.max())) if len(positive) else (0.0, 0.0)
    y = log_axis(low / 1.5, high * 1.5, title) if high > low > 0.0 else linear_axis(0.0, high, title)
    sheet = Sheet(stream, f"{ROOT}/output", x, y)
    places = np.arange(len(errors), dtype=np.float64)
    sheet.line("RMSE", places, errors / scale, AFTER, 3.5)
    sheet.dots("RMSE, points", places, errors / scale, AFTER, 10.0)
    for k, error in enumerate(errors):
        across, up = sheet.place(places[k : k + 1], errors[k : k + 1] / scale)[0]
        if math.isfinite(up):
            sheet.write(across, up - 6.0, quantity(float(error), "rad"), AFTER)
    sheet.done()


def after_tab(given: Shown, names: Sequence[str], findings: Findings | None) -> rrb.Container:
    """All models' errors on the left, how they fell on the right."""
    steps = []
    if findings is not None and findings.unseen is not None and len(findings.unseen.rmse) > 1:
        words = signal_words(findings.unseen.signal, findings.unseen.unit)
        steps.append(sheet_view(f"{ROOT}/falling", f"RMSE of the {words} after each step, on unseen recordings"))
    if findings is not None and len(_outputs(findings)) > 1:
        steps.append(sheet_view(f"{ROOT}/output", "RMSE of the output's position after each step"))
    errors = bars_view(f"{ROOT}/errors", "errors before and after, all recordings", len(_errors(given, names)))
    return rrb.Horizontal(errors, *([rrb.Vertical(*steps)] if steps else []), name="after")

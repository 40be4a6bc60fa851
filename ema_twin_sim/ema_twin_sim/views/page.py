"""A page that tells a comparison: one self-contained HTML file, before and after an effect was added."""

from __future__ import annotations

import html
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from ema_bench_replay.outputs import new_file
from ema_bench_replay.recording import Recording

from ..comparison.compare import Comparison
from ..comparison.running_comparison import UNITS, excess_removed
from ..model import Model
from ..quantities import quantity
from ..simulation.simulate import choose_input, simulate

_BENCH, _BEFORE, _AFTER = "#222222", "#d95f02", "#1b7fbd"
_SHOWN = 4.0  # s, of the time axes at first
_POINTS = 4000  # of a curve; a page stays light, and a screen shows no more
_STYLE = """
body { font-family: system-ui, sans-serif; max-width: 1200px; margin: 2em auto; padding: 0 1em; color: #222 }
table { border-collapse: collapse; margin: 1em 0 }
td, th { padding: .3em .9em; text-align: right; border-bottom: 1px solid #ddd }
td:first-child, th:first-child { text-align: left }
.good { color: #1a7f37; font-weight: 600 }
"""


def write_page(
    path: Path,
    title: str,
    story: Sequence[str],
    recording: Recording,
    models: Sequence[Model],
    comparisons: Sequence[Comparison],
) -> None:
    """Write the page: the story, the RMSE table of two models (before, after), and one recording drawn with both.

    Raises InputError where the file cannot be written.
    """
    source = choose_input(recording)
    twins = [simulate(model, recording, source) for model in models]
    figure = _curves(recording, twins, [model.name for model in models])
    plot = figure.to_html(full_html=False, include_plotlyjs=True, config={"displaylogo": False})
    paragraphs = "\n".join(f"<p>{html.escape(line)}</p>" for line in story)
    text = (
        f"<!doctype html><html lang='en'><head><meta charset='utf-8'><title>{html.escape(title)}</title>"
        f"<style>{_STYLE}</style></head><body><h1>{html.escape(title)}</h1>\n{paragraphs}\n{_table(comparisons)}\n"
        f"<h2>{html.escape(recording.name)}</h2>\n{plot}\n</body></html>\n"
    )
    with new_file(path, force=True) as file:
        file.write(text.encode())


def _table(comparisons: Sequence[Comparison]) -> str:
    before, after = comparisons[0], comparisons[-1]
    rows = []
    for name, signal in before.overall.items():
        if signal["driven"] or name not in after.overall:
            continue
        floor, first, last = signal["noise_floor"], signal["rmse"], after.overall[name]["rmse"]
        unit = signal["unit"]
        share = excess_removed(signal, after.overall[name])
        removed = "–" if share is None else f"{100.0 * share:.1f} %"
        rows.append(
            f"<tr><td>{name.replace('_', ' ')}</td><td>{quantity(floor, unit)}</td>"
            f"<td>{quantity(first, unit)} ({first / floor:.1f}×)</td>"
            f"<td>{quantity(last, unit)} ({last / floor:.1f}×)</td><td class='good'>{removed}</td></tr>"
        )
    head = f"<tr><th>RMSE, all recordings</th><th>sensors' noise</th><th>{html.escape(before.model)}</th>"
    return f"<table>{head}<th>{html.escape(after.model)}</th><th>excess removed</th></tr>{''.join(rows)}</table>"


def _curves(recording: Recording, twins: Sequence[Recording], names: Sequence[str]) -> go.Figure:
    signals = [name for name in ("output_position", "current", "speed") if recording.has(name)]
    titles = [
        text for n in signals for text in (f"{n} [{UNITS[n]}]".replace("_", " "), f"measured − twin [m{UNITS[n]}]")
    ]
    titles.append("unexplained torque [mN m] against motor speed [rad/s]")
    rows = len(signals) + 1
    specs: list = [*([{}, {}] for _ in signals), [{"colspan": 2}, None]]
    figure = make_subplots(rows=rows, cols=2, subplot_titles=titles, specs=specs, vertical_spacing=0.07)
    every = max(1, len(recording) // _POINTS)
    time = recording.time[::every]
    for row, name in enumerate(signals, 1):
        measured = recording.signals[name]
        figure.add_scatter(
            x=time, y=measured[::every], name="bench", line={"color": _BENCH, "width": 2.5}, row=row, col=1,
            legendgroup="bench", showlegend=row == 1,
        )  # fmt: skip
        for twin, label, colour in zip(twins, names, (_BEFORE, _AFTER), strict=False):
            shared = {"name": label, "line": {"color": colour, "width": 1.3}, "legendgroup": label}
            figure.add_scatter(x=time, y=twin.signals[name][::every], row=row, col=1, showlegend=row == 1, **shared)
            residual = 1e3 * (measured - twin.signals[name])[::every]
            figure.add_scatter(x=time, y=residual, row=row, col=2, showlegend=False, **shared)
    for twin, label, colour in zip(twins, names, (_BEFORE, _AFTER), strict=False):
        torque = twin.signals.get("unexplained_torque")
        if torque is not None:
            speed = _speed(recording, twin)
            figure.add_scatter(
                x=speed[::every], y=1e3 * torque[::every], mode="markers", marker={"color": colour, "size": 3},
                name=label, legendgroup=label, showlegend=False, row=rows, col=1,
            )  # fmt: skip
    figure.update_layout(height=330 * rows, template="plotly_white", legend={"orientation": "h", "y": 1.04})
    for row in range(1, len(signals) + 1):
        figure.update_xaxes(matches="x", range=[0.0, min(_SHOWN, recording.duration)], row=row)
    figure.update_xaxes(title_text="time [s]", row=len(signals))
    return figure


def _speed(recording: Recording, twin: Recording) -> np.ndarray:
    """The bench's speed (n,) [rad/s]: measured, or of its counter; else the twin's."""
    if recording.has("speed"):
        return recording.signals["speed"]
    if recording.has("motor_position"):
        return np.gradient(recording.signals["motor_position"], recording.time)
    return twin.signals["speed"]

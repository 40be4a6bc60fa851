"""How the figures look: readable at 400 pixels, told apart without colour vision, the same bytes at every run."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

BLUE, ORANGE, GREEN, RED, PURPLE, SKY = "#0072b2", "#d55e00", "#009e73", "#b2182b", "#882288", "#56b4e9"
GREY, FAINT = "#767676", "#e4e4e4"
WIDTH = 5.6  # inches, at 11 points a letter

mpl.use("svg")
mpl.rcParams.update(
    {
        "axes.grid": True,
        "axes.spines.right": False,
        "axes.spines.top": False,
        "axes.titlelocation": "left",
        "axes.titlesize": 11,
        "figure.constrained_layout.use": True,
        "figure.facecolor": "white",
        "font.size": 11,
        "grid.color": FAINT,
        "legend.fontsize": 10,
        "legend.framealpha": 0.9,
        "lines.linewidth": 1.6,
        "path.simplify_threshold": 0.5,
        "savefig.facecolor": "white",
        "svg.fonttype": "path",
        "svg.hashsalt": "ema-twin",
    }
)


def sheet(rows: int = 1, columns: int = 1, height: float = 3.4, **options: object) -> tuple[Figure, list[Axes]]:
    """A figure of the page's width and ``height`` [inches] and its axes, row by row."""
    figure = Figure(figsize=(WIDTH, height))
    return figure, list(figure.subplots(rows, columns, squeeze=False, **options).flat)


def save(figure: Figure, path: Path, description: str | None = None) -> None:
    """Write ``figure`` as SVG, without a date; ``description`` tells who does not see it what is drawn."""
    figure.savefig(path, format="svg", metadata={"Date": None, "Creator": None, "Description": description})
    path.write_text("\n".join(line.rstrip() for line in path.read_text().splitlines()) + "\n")

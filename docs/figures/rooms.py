"""The rooms of the twin's package and who imports from whom: what docs/architecture.md shows."""

from __future__ import annotations

from collections.abc import Mapping

from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch

from .imports import arrows
from .style import BLUE, GREEN, GREY, ORANGE, PURPLE, RED

PATHS = {
    "who asks": (ORANGE, ("entry", "commands")),
    "who shows": (PURPLE, ("report", "views", "nodes")),
    "what is said, and done sample by sample": (RED, ("words", "live")),
    "what is judged of a machine": (BLUE, ("campaign", "health", "discovery", "fitting", "comparison", "new_machine")),
    "what is known of a recording": (GREEN, ("identification", "measured")),
    "what is computed": (GREY, ("simulation", "own_effects", "model", "effects", "plant")),
}
"""The rooms by what they are for."""
COLOURS = {room: colour for colour, rooms in PATHS.values() for room in rooms}
WIDTH, HEIGHT = 1.55, 0.52


def needs() -> dict[str, set[str]]:
    """Which rooms each imports from; the small files beside the rooms (criteria, quantities, …) are left out."""
    found: dict[str, set[str]] = {room: set() for room in COLOURS}
    for file, wanted in arrows(typing=False):
        if file[0] in found and wanted[0] in found and file[0] != wanted[0]:
            found[file[0]].add(wanted[0])
    return found


def reached(needs: Mapping[str, set[str]], room: str) -> set[str]:
    """All that a room imports from, directly or through others."""
    return needs[room].union(*(reached(needs, other) for other in needs[room]))


def drawn(needs: Mapping[str, set[str]]) -> dict[str, set[str]]:
    """The arrows that no chain of others stands for."""
    return {
        room: {other for other in others if not any(other in reached(needs, via) for via in others - {other})}
        for room, others in needs.items()
    }


def in_words() -> list[str]:
    """The arrows of the picture, as it holds them for who cannot see it."""
    return [f"{room} imports {', '.join(sorted(others))}" for room, others in drawn(needs()).items() if others]


def floors(needs: Mapping[str, set[str]]) -> dict[str, int]:
    """How many rooms lie below each, one upon the other; what needs none stands below who needs it."""
    found: dict[str, int] = {}
    while len(found) < len(needs):
        for room, others in needs.items():
            if room not in found and others <= found.keys():
                found[room] = 1 + max((found[other] for other in others), default=-1)
    users = {room: [found[other] for other in needs if room in needs[other]] for room in needs}
    lone = [room for room in needs if not needs[room] and users[room] and min(users[room]) > 1]
    return found | {room: min(users[room]) - 1 for room in lone}  # right below who needs it


def places(floor: Mapping[str, int], arrows: Mapping[str, set[str]]) -> dict[str, tuple[float, float]]:
    """Where each room is drawn: on its floor, each above what it leads to."""
    rows: dict[int, list[str]] = {}
    for room in COLOURS:
        rows.setdefault(floor[room], []).append(room)
    found: dict[str, tuple[float, float]] = {}
    for height in sorted(rows):
        row = rows[height]

        def below(room: str) -> float:
            ends = [found[other][0] for other in arrows[room] if other in found]
            return sum(ends) / len(ends) if ends else 0.0

        row.sort(key=below)
        middle = sum(map(below, row)) / len(row) if height else 0.0
        for k, room in enumerate(row):
            found[room] = (middle + 2.0 * (k - 0.5 * (len(row) - 1)), float(height))
    return found


def draw() -> Figure:
    """Rooms as boxes, the lower the less they know of; an arrow leads to what is imported."""
    shown = needs()
    lines = drawn(shown)
    at = places(floors(shown), lines)
    left, right = min(x for x, _ in at.values()) - 1.0, max(x for x, _ in at.values()) + 1.0
    top = max(y for _, y in at.values())
    figure = Figure(figsize=(1.05 * (right - left), 0.72 * (top + 1.8)))
    axis = figure.subplots()
    axis.set_axis_off()
    axis.set_xlim(left, right)
    axis.set_ylim(-0.5, top + 1.0)
    for room, others in lines.items():
        for other in others:
            (x, y), (to_x, to_y) = at[room], at[other]
            bend = 0.0 if y - to_y < 1.5 else (0.18 if x <= to_x else -0.18)
            axis.add_patch(
                FancyArrowPatch(
                    (x, y - 0.5 * HEIGHT), (to_x, to_y + 0.5 * HEIGHT), arrowstyle="-|>", mutation_scale=11,
                    lw=1.1, color=COLOURS[room], alpha=0.75, shrinkA=0, shrinkB=1, connectionstyle=f"arc3,rad={bend}",
                )
            )  # fmt: skip
    for room, (x, y) in at.items():
        box = {"boxstyle": "round,pad=0.35", "fc": "white", "ec": COLOURS[room], "lw": 1.6}
        axis.text(x, y, room, ha="center", va="center", bbox=box, zorder=5)
    for purpose, (colour, _) in PATHS.items():
        axis.plot([], [], color=colour, lw=3, label=purpose)
    figure.legend(loc="outside upper center", ncols=2, frameon=False)
    return figure

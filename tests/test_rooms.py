"""The rooms of the twin's package: data goes down the list once, and no room knows of one further down."""

import re
from pathlib import Path

import ema_twin_sim

PACKAGE = Path(ema_twin_sim.__file__).resolve().parent
ROOMS = (
    *(
        "criteria",
        "version",
        "parallel",
        "listing",
        "quantities",
        "reading_noise",
        "plant",
        "effects",
        "model",
        "own_effects",
        "simulation",
        "measured",
    ),
    *("measured", "identification", "comparison", "fitting"),
    *("discovery/criteria", "discovery/search", "discovery/experiment"),
    *("health", "discovery", "campaign", "new_machine", "nodes", "commands", "report", "views", "start"),
)
"""From the ground up: each imports from those before it."""
UPWARDS = {("commands", "report"), ("commands", "views")}
"""What still looks up: verbs write pages and views, which tell in the verbs' words."""
_IMPORT = re.compile(r"^\s*from (\.+)([\w.]*) import", re.MULTILINE)


def room(path):
    """The room of a module, given by its parts."""
    name = "/".join(path[:2])
    return name if name in ROOMS else path[0]


def arrows():
    """(room, the other room that it imports from, file) of every relative import."""
    for file in PACKAGE.rglob("*.py"):
        parts = file.relative_to(PACKAGE).with_suffix("").parts
        for dots, target in _IMPORT.findall(file.read_text()):
            above = parts[: len(parts) - len(dots)]
            wanted = (*above, *filter(None, target.split(".")))
            if wanted and room(wanted) != room(parts):
                yield room(parts), room(wanted), file.name


def test_every_folder_is_a_room():
    folders = {p.name for p in PACKAGE.iterdir() if p.is_dir() and (p / "__init__.py").exists()}
    assert folders <= {name.split("/")[0] for name in ROOMS}


def test_data_goes_down_the_list():
    up = {(a, b) for a, b, _ in arrows() if ROOMS.index(b) > ROOMS.index(a)}
    assert up == UPWARDS, sorted((a, b, name) for a, b, name in arrows() if (a, b) in up - UPWARDS)

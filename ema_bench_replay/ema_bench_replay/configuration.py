"""Find the project's configuration: models, import maps, launch files, layouts and blueprints."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from difflib import get_close_matches
from pathlib import Path

from ema_bench_replay.errors import InputError

_PACKAGE = "ema_twin_config"


def find_configuration(kind: str, name: str | Path) -> Path:
    """The file of that kind ("models", "maps", "launch", "layouts", "blueprints") and name.

    `name` is a path to a file, or the name of a shipped one with or without its extension. Shipped files are searched
    in the folder EMA_TWIN_CONFIG, in each prefix of AMENT_PREFIX_PATH, in this Python's prefix and in the checkout, in
    this order. Raises InputError with the places tried and the nearest name.
    """
    given = Path(name)
    if given.is_file() and (given.suffix or len(given.parts) > 1):
        return given
    places = list(dict.fromkeys(folder / kind for folder in configuration_folders()))
    if len(given.parts) == 1:
        for place in places:
            for file in _files(place):
                if file.name == given.name or _bare(file) == given.name:
                    return file
    known = sorted({_bare(file) for place in places for file in _files(place)})
    if given.is_dir():
        raise InputError(f"{name}: is a folder; give a file in it, or one of the {kind}: {', '.join(known) or 'none'}")
    near = get_close_matches(_bare(given), known, n=1, cutoff=0.5)
    hint = f"did you mean {near[0]!r}?" if near else f"there are: {', '.join(known) or 'none'};"
    tried = ", ".join(map(str, places)) or "nowhere: set EMA_TWIN_CONFIG"
    raise InputError(f"{name}: not found among the {kind}; {hint} (looked in {tried})")


def configuration_names(kind: str) -> list[str]:
    """Names of all shipped files of that kind, sorted, without extension."""
    return sorted({_bare(file) for folder in configuration_folders() for file in _files(folder / kind)})


def configuration_folders() -> Iterator[Path]:
    """Every folder that may hold configuration, best first; they need not exist."""
    if chosen := os.environ.get("EMA_TWIN_CONFIG"):
        yield Path(chosen)
    for share in share_folders():
        yield share / _PACKAGE
    if root := checkout():
        yield root / "config"


def share_folders() -> Iterator[Path]:
    """The `share` folder of every prefix in which ROS packages may be installed."""
    for prefix in filter(None, os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)):
        yield Path(prefix) / "share"
    yield Path(sys.prefix) / "share"


def checkout() -> Path | None:
    """The source tree that this module runs from, or None if it is installed elsewhere."""
    for folder in Path(__file__).resolve().parents:
        if (folder / "config" / "package.xml").is_file() or (folder / "ema_twin_msgs" / "msg").is_dir():
            return folder
    return None


def _files(folder: Path) -> list[Path]:
    return sorted(file for file in folder.iterdir() if file.is_file()) if folder.is_dir() else []


def _bare(file: Path) -> str:
    """File name without its extensions (`twin.launch.py` is `twin`); unchanged if it begins with a dot."""
    return file.name.split(".")[0] or file.name

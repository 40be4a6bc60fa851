"""Whether there is a screen, and rerun's viewer on it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path


def display_available() -> bool:
    """Whether there is a screen to open the viewer on."""
    return sys.platform in ("darwin", "win32") or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def open_viewer(path: Path) -> bool:
    """Open a rerun recording in its viewer, as a process of its own; whether there was a screen to do so."""
    if not display_available():
        return False
    start_viewer(str(path))
    return True


def start_viewer(*arguments: str) -> None:
    """Start rerun's viewer as a process of its own: without our ROS libraries, and reporting to nobody."""
    environment = {k: v for k, v in os.environ.items() if k not in ("LD_LIBRARY_PATH", "PYTHONPATH")}
    environment["CI"] = "true"  # what rerun takes as "no analytics", without touching the user's configuration
    viewer = Path(sys.executable).with_name("rerun")
    subprocess.Popen([str(viewer), *arguments], env=environment, start_new_session=True)

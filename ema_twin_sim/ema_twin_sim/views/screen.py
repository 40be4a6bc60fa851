"""Check whether there is a screen, and start rerun's viewer on it."""

from __future__ import annotations

import importlib.util
import os
import socket
import subprocess
import sys
import time
from pathlib import Path

ADDRESS = "127.0.0.1"
"""Address on which viewers listen: this machine only."""
_VIEWER = Path(sys.executable).with_name("rerun")
_GRAPHICS = (
    ("/dev/dri", "*"),
    ("/dev", "nvidia*"),
    ("/dev", "dxg"),
    ("/usr/share/vulkan/icd.d", "*.json"),
    ("/etc/vulkan/icd.d", "*.json"),
)
"""Folders, and the files in them that show that there is a graphics driver."""
_PORT = 9876
_PATIENCE = 60.0
"""Time in s for a viewer to start listening: a busy machine may take long. A viewer that ends is not waited for."""
_NOWHERE = "http://127.0.0.1:9"


def display_available() -> bool:
    """Whether there is a screen to open the viewer on."""
    return sys.platform in ("darwin", "win32") or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def why_not_shown() -> str:
    """Why rerun's viewer cannot open a window here, in words; empty if nothing prevents it."""
    if not display_available():
        return "there is no display"
    if not _VIEWER.is_file():
        return "rerun's viewer is not installed"
    if sys.platform == "linux" and not any(Path(place).glob(names) for place, names in _GRAPHICS):
        return "there is no graphics driver (on Debian or Ubuntu: sudo apt install mesa-vulkan-drivers)"
    return ""


def open_live_viewer() -> str:
    """Open a viewer for live data; return its address, or an empty string if it does not start."""
    viewer = start_viewer("--port", str(_PORT), "--bind", ADDRESS, "--hide-welcome-screen")
    return f"rerun+http://{ADDRESS}:{_PORT}/proxy" if comes_up(viewer, _PORT) else ""


def start_viewer(*arguments: str) -> subprocess.Popen[bytes]:
    """Start rerun's viewer as a separate process, which stays when this one ends."""
    return subprocess.Popen([*viewer_command(), *arguments], env=viewer_environment(), start_new_session=True)


def comes_up(process: subprocess.Popen[bytes], *ports: int) -> bool:
    """Wait until all the ports listen; False if the process ends first, or takes longer than ``_PATIENCE``."""
    end = time.monotonic() + _PATIENCE
    while not all(_listens(port) for port in ports):
        if process.poll() is not None or time.monotonic() > end:
            return False
        time.sleep(0.05)
    return True


def _listens(port: int) -> bool:
    try:
        socket.create_connection((ADDRESS, port), 0.2).close()
    except OSError:
        return False
    return True


def viewer_command() -> list[str]:
    """Command of rerun's viewer: the binary itself, since the script of that name would leave it running when ended."""
    package = importlib.util.find_spec("rerun_cli")
    places = [Path(place) / "rerun" for place in (package.submodule_search_locations or ())] if package else []
    return [str(next((binary for binary in places if binary.is_file()), _VIEWER))]


def viewer_environment() -> dict[str, str]:
    """The viewer's environment: without our ROS libraries, and without reports to its makers."""
    environment = {k: v for k, v in os.environ.items() if k not in ("LD_LIBRARY_PATH", "PYTHONPATH")}
    environment["CI"] = "true"  # what rerun takes as "no analytics", without touching the user's configuration
    # it looks for a newer version at each start; the only way to prevent that is a proxy that does not exist
    environment |= dict.fromkeys(("ALL_PROXY", "all_proxy", "HTTPS_PROXY", "https_proxy"), _NOWHERE)
    return environment | dict.fromkeys(("NO_PROXY", "no_proxy"), "localhost,127.0.0.1")

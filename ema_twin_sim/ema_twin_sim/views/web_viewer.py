"""Rerun's viewer for a browser, served on this machine's loopback address."""

from __future__ import annotations

import shutil
import socket
import subprocess

from ema_bench_replay.errors import InputError

from .screen import ADDRESS, comes_up, viewer_command, viewer_environment
from .web_page import WebPage

_ENDING = 1.0
"""Time in s that the server has to end: it ignores SIGTERM while a browser is connected."""


class WebViewer:
    """Serves the viewer's page, and takes what is sent to ``sink``; ends with this process.

    Attributes:
        sink: where a recording stream sends to.
        page: what to open in a browser.
    """

    def __init__(self) -> None:
        """Start the servers. Raises InputError if rerun's does not start."""
        data, files = _free_ports(2)
        self.sink = f"rerun+http://{ADDRESS}:{data}/proxy"
        arguments = ["--serve-web", "--bind", ADDRESS, "--port", str(data), "--web-viewer-port", str(files)]
        # if this process is killed, the server must end too
        guard = ["setpriv", "--pdeathsig", "KILL"] if shutil.which("setpriv") else []
        self._process = subprocess.Popen(
            [*guard, *viewer_command(), *arguments],
            env=viewer_environment(),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,  # Ctrl-C is for us only: the server is needed until all is sent
        )
        if not comes_up(self._process, data, files):
            self._end_server()
            raise InputError("--web: rerun's web viewer does not start; give --rrd FILE and look at that later")
        self._page = WebPage(f"http://{ADDRESS}:{files}", self.sink)
        self.page = self._page.address

    def close(self) -> None:
        """End the servers."""
        self._page.close()
        self._end_server()

    def _end_server(self) -> None:
        self._process.terminate()
        try:
            self._process.wait(_ENDING)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


def _free_ports(number: int) -> list[int]:
    sockets = [socket.create_server((ADDRESS, 0)) for _ in range(number)]
    ports = [opened.getsockname()[1] for opened in sockets]
    for opened in sockets:
        opened.close()
    return ports

"""Our own page for rerun's viewer in a browser, so that nothing that it loads or sends leaves this machine."""

from __future__ import annotations

import html
import shutil
import sys
import threading
import urllib.request
from http.client import HTTPException
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

from .screen import ADDRESS

_PATIENCE = 10.0  # s, time limit for the viewer's files
_OWN = {"/": ("web_page.html", "text/html; charset=utf-8"), "/web_page.js": ("web_page.js", "text/javascript")}
_DIRECT = urllib.request.build_opener(urllib.request.ProxyHandler({}))  # a proxy does not know our loopback
_VIEWERS = {"/re_viewer.js": "text/javascript", "/re_viewer_bg.wasm": "application/wasm"}


class _Server(ThreadingHTTPServer):
    def handle_error(self, *request: Any) -> None:
        if not isinstance(sys.exc_info()[1], ConnectionError):  # else the browser has gone
            super().handle_error(*request)


class WebPage:
    """Serves the page on loopback, in threads of this process.

    Attributes:
        address: what to open in a browser.
    """

    def __init__(self, viewer: str, sink: str) -> None:
        """Take the viewer's files from the server at address ``viewer``; the viewer shows what ``sink`` receives."""
        policy = (
            "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'unsafe-inline'; "
            f"img-src data: blob:; connect-src 'self' data: blob: {sink.removeprefix('rerun+').removesuffix('/proxy')}"
        )

        class Handler(BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                path, port = self.path.partition("?")[0], self.connection.getsockname()[1]
                if self.headers.get("Host") != f"{ADDRESS}:{port}":
                    self.send_error(403)  # another site's name for this machine (DNS rebinding)
                elif path in _OWN:
                    name, kind = _OWN[path]
                    text = (Path(__file__).parent / name).read_text().replace("{sink}", html.escape(sink))
                    self._begin(kind)
                    self.wfile.write(text.encode())
                elif path in _VIEWERS:
                    try:
                        file = _DIRECT.open(viewer + path, timeout=_PATIENCE)
                    except (OSError, HTTPException):
                        self.send_error(502)
                        return
                    with file:
                        self._begin(_VIEWERS[path])
                        shutil.copyfileobj(file, self.wfile)
                else:
                    self.send_error(404)

            def _begin(self, kind: str) -> None:
                self.send_response(200)
                self.send_header("Content-Type", kind)
                self.send_header("Content-Security-Policy", policy)
                self.send_header("X-Content-Type-Options", "nosniff")
                self.end_headers()

            def log_message(self, *_arguments: object) -> None:
                """Log nothing: the terminal is for the command's output."""

        self._server = _Server((ADDRESS, 0), Handler)
        self.address = f"http://{ADDRESS}:{self._server.server_address[1]}/"
        threading.Thread(target=self._server.serve_forever, name="web page", daemon=True).start()

    def close(self) -> None:
        """Stop serving."""
        self._server.shutdown()
        self._server.server_close()

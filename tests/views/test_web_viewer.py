"""What `live --web` serves: the view drawn in a browser, on loopback, and nothing asked of anybody else."""

import io
import re
import socket
import struct
import subprocess
import threading
import time
import urllib.error
import urllib.parse
import urllib.request

import numpy as np
import pytest
from PIL import Image

from ema_twin_sim.views.palette import BEFORE, MEASURED
from ema_twin_sim.views.web_page import WebPage
from ema_twin_sim.views.web_viewer import WebViewer
from tests.browser import CHROMIUM, Browser
from tests.command_line import ENDING, TWIN
from tests.conftest import RECORDINGS

DIRECT = urllib.request.build_opener(urllib.request.ProxyHandler({}))


@pytest.fixture(scope="module")
def viewer():
    viewer = WebViewer()
    yield viewer
    viewer.close()


def answer(address, path="", **headers):
    try:
        with DIRECT.open(urllib.request.Request(address + path, headers=headers), timeout=ENDING) as got:
            return got.status, got.headers, got.read()
    except urllib.error.HTTPError as error:
        return error.code, error.headers, b""


def test_the_page_and_what_it_needs(viewer):
    status, headers, page = answer(viewer.page)
    assert status == 200 and viewer.sink.encode() in page and b"{" not in page.split(b"</style>")[1]
    assert "default-src 'none'" in headers["Content-Security-Policy"]
    (allowed,) = re.findall(r"connect-src 'self' data: blob: (\S+)", headers["Content-Security-Policy"])
    assert viewer.sink == f"rerun+{allowed}/proxy"
    for path, kind, least in (
        ("web_page.js", "text/javascript", 500),
        ("re_viewer.js", "text/javascript", 10_000),
        ("re_viewer_bg.wasm", "application/wasm", 1_000_000),
    ):
        status, headers, body = answer(viewer.page, path)
        assert (status, headers["Content-Type"]) == (200, kind) and len(body) > least


def test_only_what_is_asked_for_by_its_own_name(viewer):
    assert answer(viewer.page, "setup.py")[0] == answer(viewer.page, "../web_page.py")[0] == 404
    assert answer(viewer.page, Host="bench.example.org")[0] == 403
    port = urllib.parse.urlsplit(viewer.page).port
    outward = socket.gethostbyname(socket.gethostname())
    if not outward.startswith("127."):
        with pytest.raises(OSError):
            socket.create_connection((outward, port), 0.5)


def test_a_proxy_is_not_asked(viewer, monkeypatch):
    monkeypatch.setenv("http_proxy", "http://127.0.0.1:9")
    monkeypatch.setattr(urllib.request, "_opener", None)  # else it keeps the proxies of its first use
    assert answer(viewer.page, "re_viewer.js")[0] == 200


@pytest.mark.parametrize("upstream", ["leaves", "is not there"])
def test_a_viewer_that_does_not_answer_is_told_to_the_browser(upstream):
    with socket.create_server(("127.0.0.1", 0)) as silent:
        address = f"http://127.0.0.1:{silent.getsockname()[1]}"
        page = WebPage(address, "rerun+http://127.0.0.1:9/proxy")
        try:
            if upstream == "leaves":
                threading.Thread(target=lambda: silent.accept()[0].close(), daemon=True).start()
            else:
                silent.close()
            assert answer(page.address, "re_viewer.js")[0] == 502
        finally:
            page.close()


def test_a_browser_that_leaves_is_nothing_to_tell(viewer, capfd):
    with socket.create_connection(("127.0.0.1", urllib.parse.urlsplit(viewer.page).port)) as browser:
        browser.sendall(b"GET /re_viewer_bg.wasm HTTP/1.1\r\nHost: %s\r\n\r\n" % viewer.page[7:-1].encode())
        assert browser.recv(100).startswith(b"HTTP/1.0 200")
        browser.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))  # a reset, as of a closed tab
    assert answer(viewer.page)[0] == 200
    time.sleep(0.2)
    assert capfd.readouterr().err == ""


def test_it_ends():
    viewer = WebViewer()
    ports = [urllib.parse.urlsplit(address).port for address in (viewer.page, viewer.sink.removeprefix("rerun+"))]
    viewer.close()
    for port in ports:
        with pytest.raises(OSError):
            socket.create_connection(("127.0.0.1", port), 0.5)


def near(picture, colour):
    """How many pixels have about that colour."""
    return int(np.sum(np.abs(picture - np.array(colour)).max(axis=2) < 25))


@pytest.mark.skipif(CHROMIUM is None, reason="chromium is missing: sudo apt install chromium")
@pytest.mark.slow
@pytest.mark.timeout(300)
def test_a_browser_shows_the_live_run(tmp_path):
    """On a phone, and on a wider screen: to start once more would cost the viewer as much as all else here."""
    recording = next(RECORDINGS.glob("*sine_0.05*"))
    command = [TWIN, "live", recording, "--model", "polito_bench", "--web", "--loop"]
    heard = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "stdin": subprocess.DEVNULL}
    live = subprocess.Popen(command, text=True, **heard)
    browser = None
    try:
        page = next(line.split()[-1] for line in live.stdout if line.startswith("Open http"))
        browser = Browser(tmp_path / "browser", webgl=True)
        browser.open(page, 400, height=480)  # drawn by the processor: the less, the sooner
        browser.wait("document.querySelector('canvas')?.hidden === false")
        for width in (400, 1280):
            browser.screen(width, height=480)
            browser.wait(f"document.querySelector('canvas').width > 0.9 * {width}")  # drawn anew, not stretched
            end = time.monotonic() + 120.0
            while True:
                picture = np.asarray(Image.open(io.BytesIO(browser.window())).convert("RGB"), np.int16)
                # curves begin at the left of our layout; that which rerun makes up has its panels there
                left = picture[:, : width // 7]
                if near(left, BEFORE) > width // 10 and near(left, MEASURED) > 20:
                    break
                seen = f"{near(left, BEFORE)} pixels of the twin's curves, errors {browser.errors}"
                assert time.monotonic() < end, seen
                time.sleep(0.5)
        assert browser.errors == []
        assert {urllib.parse.urlsplit(url).hostname for url in browser.requested} == {"127.0.0.1"}
    finally:
        if browser is not None:
            browser.close()
        live.terminate()
        live.communicate(timeout=ENDING)

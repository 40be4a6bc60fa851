"""A headless Chromium that tests look through: over its debugging pipe, with nothing but the standard library."""

import base64
import json
import os
import select
import shutil
import subprocess
import time
from pathlib import Path

import psutil

from tests.command_line import ENDING

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
PATIENCE = 60.0  # s


class Browser:
    """One page at a time; ``errors`` and ``warnings`` are of its console, ``requested`` is what it loaded."""

    def __init__(self, folder, webgl=False):
        self.errors, self.warnings, self.requested = [], [], []
        self._number, self._text = 0, b""
        commands, answers = os.pipe(), os.pipe()
        self._write, self._read = commands[1], answers[0]
        # the browser takes commands on descriptor 3, and answers on 4
        shell = f'exec 3<&{commands[0]} 4>&{answers[1]}; exec "$@"'
        drawing = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"] if webgl else ["--disable-gpu"]
        options = ["--headless", "--no-sandbox", *drawing, "--disable-dev-shm-usage", "--remote-debugging-pipe"]
        self._process = subprocess.Popen(
            ["bash", "-c", shell, "bash", CHROMIUM, *options, f"--user-data-dir={folder}", "about:blank"],
            pass_fds=(commands[0], answers[1]), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        os.close(commands[0])
        os.close(answers[1])
        self._session = None
        found = self.call("Target.getTargets")["targetInfos"]
        target = next(each["targetId"] for each in found if each["type"] == "page")
        self._session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")

    @property
    def processor_time(self):
        """Seconds of a processor that all of its processes have had: a busy machine hardly moves them."""
        own = psutil.Process(self._process.pid)
        times = [process.cpu_times() for process in (own, *own.children(recursive=True))]
        return sum(each.user + each.system for each in times)

    def close(self):
        os.close(self._write)
        self._process.terminate()
        self._process.wait(timeout=ENDING)
        os.close(self._read)

    def call(self, method, **parameters):
        """Call a method of the DevTools protocol and return its result."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._write, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._next()
            if answer.get("id") == self._number:
                assert "error" not in answer, answer["error"]
                return answer["result"]

    def _next(self):
        end = time.monotonic() + PATIENCE
        while b"\0" not in self._text:
            ready, _, _ = select.select([self._read], [], [], max(0.0, end - time.monotonic()))
            assert ready, "the browser does not answer"
            part = os.read(self._read, 1 << 20)
            assert part, "the browser has left"
            self._text += part
        message, _, self._text = self._text.partition(b"\0")
        told = json.loads(message)
        self._note(told.get("method"), told.get("params"))
        return told

    def _note(self, method, told):
        if method == "Runtime.exceptionThrown":
            self.errors.append(told["exceptionDetails"])
        elif method == "Runtime.consoleAPICalled" and told["type"] in ("error", "warning", "assert"):
            said = [each.get("value", each.get("description")) for each in told["args"]]
            (self.warnings if told["type"] == "warning" else self.errors).append(said)
        elif method == "Log.entryAdded" and told["entry"]["level"] in ("error", "warning"):
            (self.warnings if told["entry"]["level"] == "warning" else self.errors).append(told["entry"]["text"])
        elif method == "Network.requestWillBeSent":
            self.requested.append(told["request"]["url"])

    def look(self, page, width=1280, height=900, scheme="light"):
        """Open a file as a screen of that width shows it, and wait until its charts are drawn."""
        self.open(Path(page).resolve().as_uri(), width, height, scheme)
        self.wait("document.documentElement?.dataset.drawn !== undefined")

    def open(self, address, width=1280, height=900, scheme="light"):
        """Open an address as a screen of that width shows it."""
        self.screen(width, height, scheme)
        self.call("Page.navigate", url=address)

    def screen(self, width, height, scheme="light"):
        """Show what is open on a screen of that size."""
        phone = width < 600
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=phone)
        self.call("Emulation.setTouchEmulationEnabled", enabled=phone)
        self.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])

    def wait(self, expression):
        end = time.monotonic() + PATIENCE
        while not self._asked(expression):
            assert time.monotonic() < end, f"never became true: {expression}"
            time.sleep(0.05)

    def _asked(self, expression):
        """What a page answers; nothing while another takes its place."""
        try:
            return self.ask(expression)
        except AssertionError as error:
            if "navigated" not in str(error):
                raise
            return None

    def ask(self, expression):
        """The value of a JavaScript expression in the page."""
        result = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in result, result["exceptionDetails"]
        return result["result"].get("value")

    def window(self):
        """What the window shows, as a PNG."""
        return base64.b64decode(self.call("Page.captureScreenshot")["data"])

    def picture(self, path):
        """Save the whole page as a PNG."""
        size = self.call("Page.getLayoutMetrics")["cssContentSize"]
        clip = {"x": 0, "y": 0, "width": size["width"], "height": size["height"], "scale": 1}
        shot = self.call("Page.captureScreenshot", captureBeyondViewport=True, clip=clip)
        Path(path).write_bytes(base64.b64decode(shot["data"]))

    def print(self, path):
        """Save the page as it is printed, as a PDF."""
        Path(path).write_bytes(
            base64.b64decode(self.call("Page.printToPDF", paperWidth=8.27, paperHeight=11.7)["data"])
        )

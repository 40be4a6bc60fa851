"""A headless rerun viewer that tests look through: drawn by the processor (lavapipe), and on loopback only."""

import shutil
import socket
import subprocess
import tempfile
import time
from pathlib import Path

from ema_twin_sim.views.screen import viewer_environment
from tests.command_line import ENDING

LAVAPIPE = next(Path("/usr/share/vulkan/icd.d").glob("lvp_icd*.json"), None)
REASON = "lavapipe, which draws rerun's views without a graphics card, is missing: sudo apt install mesa-vulkan-drivers"
SIZE = (1280, 800)  # pixels
PATIENCE = 60.0  # s


class Viewer:
    """One viewer with the files that it opened."""

    def __init__(self, *files):
        import rerun_cli
        from rerun.experimental import ViewerClient

        self._home = tempfile.mkdtemp()
        with socket.socket() as taken:
            taken.bind(("127.0.0.1", 0))
            port = taken.getsockname()[1]
        homes = dict.fromkeys(("HOME", "XDG_DATA_HOME", "XDG_CONFIG_HOME", "XDG_RUNTIME_DIR"), self._home)
        environment = viewer_environment() | homes | {"RUST_LOG": "off", "VK_ICD_FILENAMES": str(LAVAPIPE)}
        size = f"{SIZE[0]}x{SIZE[1]}"
        options = ["--headless", "--bind", "127.0.0.1", "--port", str(port), "--window-size", size]
        viewer = Path(rerun_cli.__file__).with_name("rerun")
        self._process = subprocess.Popen(
            [viewer, *options, "--hide-welcome-screen", *map(str, files)],
            env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        self._client = self._wait(lambda: ViewerClient.connect(f"rerun+http://127.0.0.1:{port}/proxy"))
        self._wait(self._loaded)

    def close(self):
        self._process.terminate()
        self._process.wait(timeout=ENDING)
        shutil.rmtree(self._home, ignore_errors=True)

    def _loaded(self):
        state = self._client.get_state()
        return bool(state.active_recording and not state.loading and state.views)

    def _wait(self, call):
        """What a call gives, once it neither fails nor gives nothing."""
        end = time.monotonic() + PATIENCE
        while True:
            try:
                if found := call():
                    return found
            except (ConnectionError, RuntimeError, ValueError):
                pass  # the viewer is not up yet
            assert time.monotonic() < end and self._process.poll() is None, "the viewer does not answer"
            time.sleep(0.1)

    def show(self, *tabs):
        """Bring the tabs of these names to the front, one inside the other."""
        blueprint = dict(self._client.get_blueprint().blueprint)
        kind = "ContainerBlueprint"
        containers = {path: parts[kind] for path, parts in blueprint.items() if kind in parts}
        for name in tabs:
            (inner,) = (path for path, parts in containers.items() if parts.get("display_name") == name)
            for path, parts in containers.items():
                if parts["container_kind"] == "Tabs" and inner.lstrip("/") in parts["contents"]:
                    blueprint[path] = {kind: {**parts, "active_tab": inner.lstrip("/")}}
        self._client.set_blueprint(blueprint, "recording")

    def at(self, seconds):
        """Stop at a time [s] of the recording."""
        self._client.set_time("t", duration=float(seconds), play_state="paused")

    def troubles(self):
        """What the views in sight complain of."""
        return [f"{view.name}: {report}" for view in self._client.get_state().views for report in view.reports]

    def views(self):
        """The names of the views in sight."""
        return [view.name for view in self._client.get_state().views]

    def picture(self, path):
        """Save what the window shows, when it shows the same twice."""
        end, before = time.monotonic() + PATIENCE, b""
        while True:
            time.sleep(1.0)
            now = self._client.take_screenshot()
            if now == before:
                Path(path).write_bytes(now)
                return
            assert time.monotonic() < end, "the window does not come to rest"
            before = now

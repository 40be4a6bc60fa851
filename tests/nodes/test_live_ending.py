"""How a live run ends: its results are kept, whatever becomes of the viewer, of the disk or of a second Ctrl-C."""

import json
import math
import os
import re
import resource
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from ema_twin_sim.commands.live_error import ErrorPrinter
from ema_twin_sim.nodes.live_session import Pair
from ema_twin_sim.simulation.compared_signals import UNITS, noise_floors
from ema_twin_sim.views import screen
from tests.command_line import ENDING, ENVIRONMENT, MODEL, TWIN, told
from tests.commands.test_interrupts import listening

GONE = "warning: the viewer closed before it had shown all samples; the run goes on without it"
SMALL = 100_000
"""Bytes that a file may have where the disk is to be full."""


def small_files():
    resource.setrlimit(resource.RLIMIT_FSIZE, (SMALL, SMALL))


def begun(*arguments):
    """A live run in a process group of its own, when it has told of its first error."""
    live = subprocess.Popen(
        [TWIN, "live", *map(str, arguments)],
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=ENVIRONMENT,
        preexec_fn=listening, start_new_session=True,
    )  # fmt: skip
    for line in live.stdout:
        if " error " in line:
            return live
    raise AssertionError(live.communicate()[1])


def program_of(process):
    """The name of the program that a process runs."""
    return Path(Path(f"/proc/{process}/cmdline").read_text().split("\0")[0]).name


class TestViewer:
    @pytest.fixture
    def outputs(self, tmp_path):
        return tmp_path / "better.yaml", tmp_path / "live.json"

    def test_an_interrupt_of_the_whole_group_keeps_the_results(self, ramp, outputs):
        model, figures = outputs
        live = begun(ramp, *MODEL, "--web", "-o", model, "--json", figures)
        os.killpg(live.pid, signal.SIGINT)
        printed, errors = live.communicate(timeout=ENDING)
        assert (live.returncode, told(errors)) == (130, ["interrupted; what is written is kept"])
        assert "RMSE" in printed and model.exists()
        assert json.loads(figures.read_text())["overall"]["current"]["rmse"] > 0.0

    @pytest.mark.slow
    def test_a_viewer_that_goes_away_is_a_warning(self, ramp, outputs):
        model, figures = outputs
        live = begun(ramp, *MODEL, "--web", "--to", "4", "-o", model, "--json", figures)
        # the viewer need not be the only child
        children = Path(f"/proc/{live.pid}/task/{live.pid}/children").read_text().split()
        (server,) = (child for child in children if program_of(child) == "rerun")
        os.kill(int(server), signal.SIGKILL)
        printed, errors = live.communicate(timeout=ENDING)
        assert (live.returncode, told(errors)) == (0, [GONE])
        assert "RMSE" in printed and model.exists() and json.loads(figures.read_text())["complete"]

    def test_one_that_does_not_come_up(self, monkeypatch):
        with socket.create_server((screen.ADDRESS, 0)) as taken:
            free = taken.getsockname()[1]
        monkeypatch.setattr(screen, "_PORT", free)
        monkeypatch.setattr(screen, "viewer_command", lambda: ["false"])
        assert screen.open_live_viewer() == ""
        monkeypatch.setattr(screen, "viewer_command", lambda: ["sh", "-c", "sleep 60"])
        monkeypatch.setattr(screen, "_PATIENCE", 0.2)
        started = []
        start_viewer = screen.start_viewer
        monkeypatch.setattr(screen, "start_viewer", lambda *words: started.append(start_viewer(*words)) or started[0])
        assert screen.open_live_viewer() == ""
        started[0].kill()
        started[0].wait()

    @pytest.mark.slow
    @pytest.mark.parametrize("listens", [False, True])
    def test_one_that_takes_nothing_is_not_waited_for(self, listens):
        """Neither where the view is closed, nor where the process ends; what patience there is, is cut for the test."""
        program = """
import sys
from ema_twin_sim.commands.live_view import LiveView
from ema_twin_sim.model import load_model
from ema_twin_sim.nodes.live_session import Pair
from ema_twin_sim.simulation.compared_signals import noise_floors
from ema_twin_sim.views import stream
from ema_twin_sim.views.rerun_view import RerunView
stream._VIEWER_PATIENCE = 1.0
floors = noise_floors(load_model("polito_bench"))
view = LiveView(RerunView(sys.argv[1], "a run", floors))
view.take([Pair(k, {"current": 1.0}, {"current": 1.0}, {"current": 0.0}) for k in range(100)])
view.close()
print("closed")
"""
        with socket.create_server((screen.ADDRESS, 0)) as server:
            port = server.getsockname()[1]
            if not listens:
                server.close()
            sink = f"rerun+http://{screen.ADDRESS}:{port}/proxy"
            command = [sys.executable, "-c", program, sink]
            result = subprocess.run(command, capture_output=True, text=True, timeout=ENDING, check=False)
        assert (result.returncode, result.stdout, told(result.stderr)) == (0, "closed\n", [GONE])


class TestFullDisk:
    @pytest.mark.slow
    @pytest.mark.parametrize("verb", ["compare", "live"])
    def test_it_is_one_line(self, ramp, tmp_path, verb):
        path = tmp_path / "run.rrd"
        more = ("--headless", "--rate", "0", "--to", "8") if verb == "live" else ()
        result = subprocess.run(
            [TWIN, verb, ramp, *MODEL, *more, "--rrd", path],
            capture_output=True, text=True, timeout=ENDING, check=False, env=ENVIRONMENT, preexec_fn=small_files,
        )  # fmt: skip
        assert result.returncode == 2 and "RMSE" in result.stdout
        (line,) = told(result.stderr)
        assert line == f"error: {path}: could not be written completely; free some space, or choose another folder"
        assert list(tmp_path.iterdir()) == ([path] if verb == "live" else [])  # live, what fitted is kept


def test_a_second_interrupt_leaves_a_whole_bag(ramp, tmp_path):
    bag = tmp_path / "bag"
    live = begun(ramp, *MODEL, "--headless", "--record", bag)
    live.send_signal(signal.SIGINT)
    time.sleep(0.2)
    live.send_signal(signal.SIGINT)
    _, errors = live.communicate(timeout=ENDING)
    assert (live.returncode, told(errors)) == (130, ["interrupted; what is written is kept"])
    assert (bag / "metadata.yaml").exists()
    assert (bag / "bag.mcap").read_bytes().endswith(b"\x89MCAP0\r\n")


def test_a_run_that_does_not_start_keeps_the_bag_before(ramp, stock, tmp_path, monkeypatch):
    from ema_bench_replay.load import load
    from ema_twin_sim.nodes import live

    bag = tmp_path / "bag.mcap"
    bag.write_text("precious")

    def fail(*_, **__):
        raise OSError("no node")

    monkeypatch.setattr(live, "ReplayNode", fail)
    with pytest.raises(OSError, match="no node"):
        live.run_live(load(ramp), stock, record_to=tmp_path, replaced=[bag])
    assert bag.read_text() == "precious"


@pytest.mark.parametrize(
    ("nothing_of", "known"),
    [
        ((), ("output_position", "current", "speed")),
        (("output_position",), ("current", "speed")),
        (("output_position", "current", "speed"), ("unexplained_torque",)),
        ("current drives", ("unexplained_torque",)),
    ],
)
def test_the_live_line_tells_what_is_known(stock, capsys, monkeypatch, nothing_of, known):
    """Also beside a bench of which nothing was said before; and each run by itself."""
    monkeypatch.setattr("ema_twin_sim.commands.live_error.is_narrow", lambda: False)
    printer = ErrorPrinter(noise_floors(stock), None)

    def pairs(stamps, value):
        residuals = {name: math.nan if name in nothing_of else value for name in UNITS}
        if nothing_of == "current drives":
            residuals = {**dict.fromkeys(UNITS, value), "current": 0.0}
        return [Pair(int(stamp), {}, {}, residuals) for stamp in stamps]

    printer.take(pairs(np.arange(5) * 1e8, 1000.0))
    printer.take(pairs(np.arange(12) * 1e8, 2.0))
    (line,) = capsys.readouterr().out.splitlines()
    assert [name for name in UNITS if name.replace("_", " ") in line] == [name for name in UNITS if name in known]
    assert len(re.findall(r" 2\.00 ", line)) == len(known)

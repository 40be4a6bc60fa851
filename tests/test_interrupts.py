"""Ctrl-C ends every verb in one line with status 130, whatever it is doing."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.command_line import MODEL, TWIN


def listening():
    """Before a child begins: Ctrl-C is not ignored, as it is where the tests run in a shell's background."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def interruptible(*arguments):
    """The command, running, from the moment on that it listens for Ctrl-C."""
    process = subprocess.Popen(
        [TWIN, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=listening
    )
    proc = Path(f"/proc/{process.pid}")
    deadline = time.monotonic() + 30.0
    while time.monotonic() < deadline:
        caught = next(line for line in (proc / "status").read_text().splitlines() if line.startswith("SigCgt"))
        if b"python" in (proc / "cmdline").read_bytes().split(b"\0")[0] and int(caught.split()[1], 16) & 2:
            return process
        time.sleep(0.005)
    raise AssertionError(f"{arguments[0]} does not listen for Ctrl-C")


@pytest.mark.parametrize("seconds", [0.1, 0.5, 1.5, 3.0])
@pytest.mark.parametrize("verb", ["discover", "live"])
def test_an_interrupt_is_one_line_at_any_moment(tmp_path, traces, verb, seconds):
    given = (*traces, "-o", tmp_path / "new.yaml") if verb == "discover" else (traces[0], "--headless")
    process = interruptible(verb, *given, *MODEL)
    time.sleep(seconds)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=20)
    lines = [line for line in errors.splitlines() if not line.startswith("[INFO]")]  # of the live run's nodes
    assert (process.returncode, lines) == (130, ["interrupted; what is written is kept"])
    assert not list(tmp_path.iterdir())


def test_an_interrupt_that_python_drops_or_turns_into_another_error(tmp_path):
    """Within a finaliser nobody is told of it; within an import it may become any error."""
    program = """
import os, signal, sys
from ema_twin_sim import start
from ema_twin_sim.commands import main
class Dropped:
    def __del__(self):
        os.kill(os.getpid(), signal.SIGINT)
def fail(**_):
    try:
        os.kill(os.getpid(), signal.SIGINT)
    except KeyboardInterrupt:
        raise ImportError("half of a library") from None
def drop(**_):
    Dropped()
main.app = {"fail": fail, "drop": drop, "typer": lambda **_: 130}[sys.argv[1]]
main.main()
"""
    for case in ("fail", "drop", "typer"):
        command = [sys.executable, "-c", program, case]
        result = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False, preexec_fn=listening)
        assert (result.returncode, result.stderr) == (130, "interrupted; what is written is kept\n"), case


def test_an_interrupt_after_all_is_done_changes_nothing():
    program = """
import atexit, os, signal
from ema_twin_sim.commands import main
main.app = lambda **_: atexit.register(os.kill, os.getpid(), signal.SIGINT) and 0
main.main()
"""
    command = [sys.executable, "-c", program]
    result = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False, preexec_fn=listening)
    assert (result.returncode, result.stderr) == (0, "")


def test_interrupted_live_ends_with_130(traces):
    process = interruptible("live", traces[0], "--model", "polito_bench", "--headless")
    for line in process.stdout:
        if "error" in line:
            break
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=20)
    assert process.returncode == 130, errors
    assert "Traceback" not in errors

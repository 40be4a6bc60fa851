"""Ctrl-C ends every verb in one line with status 130, whatever it is doing."""

import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.command_line import ENDING, MODEL, TWIN, told


def listening():
    """Before a child begins: Ctrl-C is not ignored, as it is where the tests run in a shell's background."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def interruptible(*arguments):
    """The command, running, from the moment on that it listens for Ctrl-C."""
    process = subprocess.Popen(
        [TWIN, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=listening
    )
    proc = Path(f"/proc/{process.pid}")
    deadline = time.monotonic() + ENDING
    while time.monotonic() < deadline:
        caught = next(line for line in (proc / "status").read_text().splitlines() if line.startswith("SigCgt"))
        if b"python" in (proc / "cmdline").read_bytes().split(b"\0")[0] and int(caught.split()[1], 16) & 2:
            return process
        time.sleep(0.005)
    raise AssertionError(f"{arguments[0]} does not listen for Ctrl-C")


def ended(program, *arguments):
    """What came of a Python program that interrupts itself."""
    command = [sys.executable, "-c", program, *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=ENDING, check=False, preexec_fn=listening)


@pytest.fixture(scope="module")
def many(tmp_path_factory, traces):
    """Recordings enough that the search is far from over at any of the moments, on a quick machine too.

    It takes as many times longer as there are copies.
    """
    folder = tmp_path_factory.mktemp("many")
    return [shutil.copy(trace, folder / f"{copy}_{trace.name}") for copy in range(6) for trace in traces]


@pytest.mark.parametrize("seconds", [0.1, 0.5, 1.5, pytest.param(3.0, marks=pytest.mark.slow)])
@pytest.mark.parametrize("verb", ["discover", "live"])
def test_an_interrupt_is_one_line_at_any_moment(tmp_path, traces, many, verb, seconds):
    given = (*many, "-o", tmp_path / "new.yaml") if verb == "discover" else (traces[0], "--headless")
    process = interruptible(verb, *given, *MODEL)
    time.sleep(seconds)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=ENDING)
    assert (process.returncode, told(errors)) == (130, ["interrupted; what is written is kept"])
    assert not list(tmp_path.iterdir())


def test_an_interrupt_that_python_drops_or_turns_into_another_error(tmp_path):
    """Within a finaliser nobody is told of it; within an import it may become any error."""
    program = """
import os, signal, sys
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
main.application = lambda _: {"fail": fail, "drop": drop, "typer": lambda **_: 130}[sys.argv[1]]
main.main()
"""
    for case in ("fail", "drop", "typer"):
        result = ended(program, case)
        assert (result.returncode, result.stderr) == (130, "interrupted; what is written is kept\n"), case


def test_an_interrupt_after_all_is_done_changes_nothing():
    program = """
import atexit, os, signal
from ema_twin_sim.commands import main
main.application = lambda _: lambda **_: atexit.register(os.kill, os.getpid(), signal.SIGINT) and 0
main.main()
"""
    result = ended(program)
    assert (result.returncode, result.stderr) == (0, "")


def test_interrupted_live_ends_with_130(traces):
    process = interruptible("live", traces[0], "--model", "polito_bench", "--headless")
    for line in process.stdout:
        if "error" in line:
            break
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=ENDING)
    assert process.returncode == 130, errors
    assert "Traceback" not in errors

"""Random inputs break no promise of those who read them; ``make fuzz`` reads as many as one likes."""

import os
import re
import signal
import subprocess
import threading
import time

import pytest

from ema_bench_replay.errors import LONGEST, InputError
from tests.fuzz import run
from tests.fuzz.kinds import KINDS
from tests.fuzz.run import read_inputs
from tests.fuzz.worker import Worker

FEW = 250


@pytest.mark.slow
@pytest.mark.parametrize("name", KINDS)
def test_what_is_read_breaks_no_promise(name, tmp_path):
    found = read_inputs(name, tmp_path, FEW, seed=7)
    assert found["faults"] == {}
    assert found["inputs"] == FEW and found["refused"] + found["read"] + found["not run"] == FEW
    assert found["read"] > 0 and found["refused"] > 0  # it is neither all noise nor all the examples themselves


@pytest.mark.slow
@pytest.mark.parametrize(
    ("breaks", "told"),
    [
        (lambda path: 1 / 0, "ZeroDivisionError in .*"),
        (lambda path: spend(2.2), "takes longer than 2 s"),
    ],
)
def test_what_breaks_a_promise_is_found(breaks, told, tmp_path):
    worker = Worker("command", tmp_path, seed=1)
    worker.read = breaks
    worker.one(b"any")
    assert any(re.fullmatch(told, fault) for fault in worker.faults), worker.faults


@pytest.mark.slow
def test_a_process_that_waits_for_a_processor_is_not_taken_to_hang(tmp_path, monkeypatch):
    """On a busy machine half a minute passed between two inputs of a millisecond each."""
    monkeypatch.setattr(run, "PATIENCE", 0.3)
    plain, folder = subprocess.Popen, tmp_path / "command_3"

    def halted(*arguments, **options):
        process = plain(*arguments, **options)

        def halt():
            while not (folder / "now").exists() or not any((folder / "now").read_bytes()[:8]):
                time.sleep(0.01)
            os.kill(process.pid, signal.SIGSTOP)
            time.sleep(1.0)
            os.kill(process.pid, signal.SIGCONT)

        threading.Thread(target=halt, daemon=True).start()
        return process

    monkeypatch.setattr(run.subprocess, "Popen", halted)
    found = read_inputs("command", tmp_path, 300, seed=3)
    assert (found["faults"], found["inputs"]) == ({}, 300)


def spend(seconds):
    until = time.process_time() + seconds
    while time.process_time() < until:
        pass


def test_a_refusal_is_one_line_that_a_terminal_does_not_obey():
    assert str(InputError("run.csv: line 3:\nbell \x07, red \x1b[31m\udc80; mend it")) == (
        "run.csv: line 3: bell \\x07, red \\x1b[31m\\udc80; mend it"
    )


def test_a_long_refusal_keeps_its_file_and_its_remedy():
    text = str(InputError(f"run.csv: {'x' * 1000}; mend it"))
    assert len(text) <= LONGEST and text.startswith("run.csv: xx") and text.endswith("xx; mend it")

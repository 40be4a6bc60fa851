"""The tutorial of the live bench: its keys in a terminal, its nodes and services on a graph, its words for `ros2`."""

import os
import re
import select
import shlex
import struct
import subprocess
import termios
import time
from dataclasses import replace
from fcntl import ioctl
from importlib import import_module

import pytest

from ema_bench_replay.nodes import replay
from ema_twin_sim.effects.catalogue import catalogue
from ema_twin_sim.nodes import monitor, twin
from tests.command_line import ENVIRONMENT, TWIN
from tests.launch_files import started
from tests.tutorials import check, page, prepare, run, steps

PATIENCE = 240.0
"""s that anything may take here, since other tests run beside it."""
KEYS = (
    ("d", r"\n *10\.0 of 20 s"),
    ("a", r"Press a to add"),
    ("q", r"Watch the error fall(.*\n)+? .*position [^\n]* [1-3]×  current [^\n]* [1-3]×"),
)
"""What is pressed, and what must be on the terminal before: the last, an error that has fallen to about the noise. What
exactly stays depends on the samples that were judged."""
FASTER = ("--rate", "4")
"""Than a person would want it."""
LOOPED = "-p loop:=true"
"""Of the replay as a node, beside which it is told to be faster."""
WIDE = struct.pack("HHHH", 50, 240, 0, 0)


class Terminal:
    """A program in a terminal of its own, as wide as it needs to print no line on two."""

    def __init__(self, words, folder):
        here, there = os.openpty()
        ioctl(there, termios.TIOCSWINSZ, WIDE)
        environment = {name: value for name, value in ENVIRONMENT.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")}
        self.process = subprocess.Popen(
            words, stdin=there, stdout=there, stderr=there, cwd=folder, env=environment | {"TERM": "xterm"}
        )
        os.close(there)
        self.end = here
        self.printed = ""

    def wait_for(self, pattern):
        until = time.monotonic() + PATIENCE
        while not re.search(pattern, self.printed):
            assert time.monotonic() < until and self._read(), self.printed

    def press(self, key):
        os.write(self.end, key.encode())

    def wait_for_end(self):
        while self._read():
            pass
        return self.process.wait(PATIENCE)

    def _read(self):
        """Whether there may be more."""
        if not select.select([self.end], [], [], 1.0)[0]:
            return True
        try:
            read = os.read(self.end, 65536).decode(errors="replace")
        except OSError:  # so a terminal says that its program has ended
            return False
        self.printed += read.replace("\r", "")
        return bool(read)

    def close(self):
        self.process.kill()
        self.process.wait()
        os.close(self.end)


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_three_keys(tmp_path):
    step = steps(page("live"))[0]
    folder = prepare(tmp_path)
    command, *words = shlex.split(step.commands)
    terminal = Terminal([TWIN.parent / command, *words, *FASTER], folder)
    try:
        for key, seen in KEYS:
            terminal.wait_for(seen)
            terminal.press(key)
        assert terminal.wait_for_end() == 0, terminal.printed
    finally:
        terminal.close()
    check(step, terminal.printed)
    model = (folder / "better_live.yaml").read_text()
    assert "backlash" in model and "stribeck_friction" in model


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_the_nodes_and_a_client_of_the_services(tmp_path):
    step = steps(page("live"))[1]
    assert LOOPED in step.commands
    printed = run(replace(step, commands=step.commands.replace(LOOPED, f"{LOOPED} -p rate:=2.0")), prepare(tmp_path))
    check(step, printed)
    before, after = (
        [float(number) for number in re.findall(r"(\d+\.\d+) m", line)]
        for line in printed.splitlines()
        if line.startswith(("before:", "after:"))
    )
    current, torque, position = [now / earlier for now, earlier in zip(after, before, strict=True)]
    assert current < 0.5 and torque < 0.5 and position < 0.02


def test_the_words_for_ros2_name_what_there_is():
    commands = [shlex.split(line) for line in re.findall(r"^\$ ros2 (.*)$", page("live"), re.MULTILINE)]
    assert {words[0] for words in commands} == {"run", "launch", "service", "topic", "param"}
    nodes = {"twin": twin, "monitor": monitor, "replay": replay}
    for words in commands:
        if words[0] == "run":
            module = nodes[words[2]]
            assert module.__name__.startswith(words[1])
            known = {declaration.name: declaration for declaration in module.PARAMETERS}
            for name, _, _ in (word.partition(":=") for word in words if ":=" in word):
                assert name in known
        elif words[0] == "launch":
            _, package, file, *given = words
            assert package == "ema_twin_config"
            started(file.removesuffix(".launch.py"), **dict(word.split(":=") for word in given))
        elif words[0] == "service":
            _, _, service, kind, request = words
            package, _, name = kind.split("/")
            assert hasattr(import_module(f"{package}.srv"), name) and request == "{}"
            assert service in ("/monitor/diagnose", "/monitor/apply")
        elif words[0] == "param":
            _, _, node, parameter, _ = words
            _, effect, name = parameter.split(".")
            assert node == "/twin" and effect in catalogue()
            assert name == "enabled" or name in {held.name for held in catalogue()[effect].parameters}

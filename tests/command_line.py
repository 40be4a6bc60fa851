"""The command line as tests call it: what it answers, and the one line of a refusal."""

import os
import subprocess
import sys
from functools import cache
from pathlib import Path

from tests.command_server import CommandServer

TWIN = Path(sys.prefix) / "bin" / "ema-twin"
MODEL = ("--model", "polito_bench")
LONGEST = 300.0
"""s that a command may take: a kernel may have to be compiled first, on a busy machine."""
ENDING = 60.0
"""s in which a process must end that was told to, or that has little to do; alone on a machine it takes far less."""

# as wide as without a terminal: readline, which pytest loads, leaves a COLUMNS behind that only its children see
ENVIRONMENT = {name: value for name, value in os.environ.items() if name != "COLUMNS"}


STARTS_PROCESSES = {"live", "campaign", "demo"}
"""Verbs that are no single process, and are given to one that was just started, but where they are refused before."""


@cache
def server():
    return CommandServer(ENVIRONMENT)


def twin(*arguments, cwd=None, timeout=LONGEST, answers=None, started=None):
    """What a command answers; ``started``: whether of a process that was started for it, as a shell does."""
    arguments = [*map(str, arguments)]
    if not (STARTS_PROCESSES & {*arguments} if started is None else started):
        return server().run(arguments, cwd, timeout, answers)
    return subprocess.run(
        [TWIN, *arguments],
        capture_output=True,
        text=True,
        cwd=cwd,
        timeout=timeout,
        check=False,
        input=answers,
        env=ENVIRONMENT,
    )


def done(*arguments, **options):
    result = twin(*arguments, **options)
    assert result.returncode == 0, result.stderr
    return result


def done_here(*arguments):
    """The same verbs in this process, where many follow each other: each process of its own imports for two seconds."""
    from ema_twin_sim.commands.main import application

    assert not application()([*map(str, arguments)], standalone_mode=False, prog_name="ema-twin")


def told(errors):
    """The lines on the error output, but for what nodes log, and that a kernel is compiled first."""
    return [line for line in errors.splitlines() if not line.startswith(("[INFO]", "[WARN]", "compiling "))]


def refused(*arguments, naming=(), **options):
    """The one line that a refusal is."""
    result = twin(*arguments, **{"started": "campaign" in arguments, **options})
    assert result.returncode == 2, (result.returncode, result.stdout, result.stderr)
    lines = [line for line in result.stderr.splitlines() if not line.startswith(("warning:", "compiling "))]
    assert len(lines) == 1 and lines[0].startswith("error: "), result.stderr
    for word in naming:
        assert word in lines[0], lines[0]
    return lines[0]

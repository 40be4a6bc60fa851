"""What a page of the documentation tells to type, and what it shows that comes of it.

A page's ``shell`` blocks are commands. A ``text`` block shows lines that the last commands before it print, in their
order; "…" in one stands for anything, and a number for one near it: another processor's last digits differ. Where the
first line shown is an error, the commands end with status 2. What is in ``console`` blocks needs a set-up that the
tests do not have.
"""

import os
import re
import signal
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

from tests.command_line import ENVIRONMENT, TWIN
from tests.served_shell import served

DOCS = Path(__file__).resolve().parent.parent / "docs"
_BLOCK = re.compile(r"^```(shell|text)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_DRAWN = re.compile("[│┃]|\x1b\\[[0-9;?]*[A-Za-z]")
"""What tables and terminals put between words."""
_NUMBER = re.compile(r"(?<![\d.])(\d+(?:\.\d+)?)(?!\d|[\d.]*…)")  # whole: of one that goes on in "…" the digits stand
TOLERANCE = 0.02
"""By what share a number may be another on another machine."""


@dataclass
class Step:
    """Commands, and the lines that the page shows of what they print."""

    commands: str
    shown: list[str] = field(default_factory=list)

    @property
    def status(self):
        return 2 if self.shown and self.shown[0].startswith("error: ") else 0


def page(name):
    return (DOCS / f"tutorial_{name}.md").read_text()


def steps(text):
    """The steps of a page, from top to bottom."""
    found = []
    for kind, content in _BLOCK.findall(text):
        if kind == "shell":
            found.append(Step(content))
        else:
            found[-1].shown += content.splitlines()
    return found


def prepare(folder):
    """The folder that tutorials run in, within one that looks like the project's."""
    for name, held in (("docs", DOCS), ("tests", DOCS.parent / "tests"), (".venv", Path(sys.prefix))):
        (folder / name).symlink_to(held)
    (folder / "try").mkdir()
    return folder / "try"


def run(step, folder, timeout=600):
    """What the commands print; they end as the page says, and nothing that they started outlives them."""
    environment = ENVIRONMENT | {"PATH": f"{TWIN.parent}:{ENVIRONMENT['PATH']}"}
    with (
        served(timeout) as (given, pipes),
        subprocess.Popen(
            ["bash", "-e", "-o", "pipefail", "-c", given + step.commands],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            text=True, cwd=folder, env=environment, start_new_session=True, pass_fds=pipes,
        ) as process,
    ):  # fmt: skip
        try:
            printed, _ = process.communicate(timeout=timeout)
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
    assert process.returncode == step.status, printed
    return printed


def check(step, printed, tolerance=TOLERANCE):
    """Every line that the page shows was printed, in that order, each number within ``tolerance`` of itself."""
    rest = printed.splitlines()
    for line in step.shown:
        at = next((k for k, told in enumerate(rest) if shows(told, line, tolerance)), None)
        assert at is not None, f"not printed, or not in this place: {line}\n\n{printed}"
        rest = rest[at + 1 :]


def shows(printed, wanted, tolerance=TOLERANCE):
    """Whether ``wanted`` stands somewhere in what was printed, each number within ``tolerance`` of itself."""
    wanted = _plain(wanted)
    looked_for = "".join(
        _NUMBER.pattern if k % 2 else ".*".join(map(re.escape, part.split("…")))
        for k, part in enumerate(_NUMBER.split(wanted))
    )
    numbers = [float(number) for number in _NUMBER.findall(wanted)]
    return any(
        all(
            abs(float(told) - number) <= tolerance * number
            for told, number in zip(place.groups(), numbers, strict=True)
        )
        for place in re.finditer(looked_for, _plain(printed))
    )


def _plain(line):
    return " ".join(_DRAWN.sub(" ", line).split())

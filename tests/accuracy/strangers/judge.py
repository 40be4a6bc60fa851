"""What a stranger gets: ``init`` on the first recording, ``discover`` on all, nothing edited; and what it is worth."""

from __future__ import annotations

import json
import subprocess
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from tests.command_line import LONGEST, TWIN

from .cases import Stranger
from .textbook import Textbook

NAMING: dict[str, tuple[str, ...]] = {
    "mA as A": ("mA",),
    "A as mA": ("mA",),
    "current turned": ("sign", "turned"),
    "speed turned": ("sign", "turned"),
    "deg as rad": ("degree",),
    "rpm as rad/s": ("rpm",),
    "ms as s": ("ms",),
}
"""One of these words must be in what a mistake is answered with."""


Call = Callable[..., "subprocess.CompletedProcess[str]"]
"""Runs ``ema-twin`` with these words."""


@dataclass(frozen=True)
class Answer:
    """One case and what came of it."""

    case: str
    hidden: tuple[str, ...]
    mistake: str
    added: tuple[str, ...]
    verdict: str  # as discover says it, or refused
    right: bool
    wrong: bool  # something named confidently that is not there
    seconds: float
    told: str  # the refusal or the warnings, in a line
    off: Mapping[str, float] = field(default_factory=dict)  # of each constant, its error over its standard error

    def line(self) -> str:
        """One line for the screen."""
        asked = self.mistake or ",".join(self.hidden) or "-"
        how = "ok   " if self.right else "WRONG" if self.wrong else "MISS "
        return (
            f"{self.case} {how} {asked:22s} added={','.join(self.added) or '-'} {self.verdict} {self.seconds:.1f} s"
            + (f" {self.told[:300]}" if not self.right or self.mistake else "")
        )


def answered(
    case: Stranger | Textbook, without: Sequence[str] = (), folder: Path | None = None, call: Call | None = None
) -> Answer:
    """Give a case to the commands; its files are kept where a folder is given.

    ``call`` runs a command; without it each is a process that is started for it.
    """
    if folder is None:
        with tempfile.TemporaryDirectory() as place:
            return answered(case, without, Path(place), call)
    call = call or _started
    files = [str(file) for file in case.write(folder)]
    start = time.perf_counter()
    model, found = folder / "servo.yaml", folder / "answer_found.json"
    begun = call("init", files[0], "-o", str(folder / "servo"), "--force", *case.options)
    said = begun.stderr + begun.stdout
    answer = None
    if begun.returncode == 0:
        left_out = [word for id in without for word in ("--without", id)]
        done = call(
            *("discover", *files, "--map", str(folder / "servo_map.yaml"), "--model", str(model)),
            *("-o", str(folder / "found.yaml"), "--force", "--json", str(found), *left_out),
        )
        said += done.stderr + done.stdout
        answer = json.loads(found.read_text("utf-8")) if done.returncode == 0 else None
    (folder / "said.txt").write_text(said, "utf-8")
    return _judged(case, answer, said, time.perf_counter() - start)


def _judged(case: Stranger | Textbook, answer: dict | None, said: str, seconds: float) -> Answer:
    added = tuple(answer["added"]) if answer else ()
    verdict = answer["verdict"] if answer else "refused"
    alarms = [line for line in said.splitlines() if line.startswith(("error:", "warning:"))]
    groups = answer.get("groups", ()) if answer else ()
    grouped = {id for group in groups if set(group) & set(case.hidden) for id in group} | {*case.besides}
    wrong = bool(set(added) - set(case.hidden) - grouped)
    if case.mistake:
        right = any(word in line for line in alarms for word in NAMING[case.mistake])
    else:
        more = set(added) - set(case.hidden)
        all_named = set(added) >= set(case.hidden) and more <= set(case.besides)
        right = all_named and verdict == ("explained" if added else "none")
    off = _off(case, answer) if answer and right and not case.mistake else {}
    return Answer(case.name, case.hidden, case.mistake, added, verdict, right, wrong, seconds, " | ".join(alarms), off)


def _off(case: Stranger | Textbook, answer: dict) -> dict[str, float]:
    """The errors of inertia and friction, each over its standard error; both shafts together."""
    truth = case.constants
    sums: dict[str, list[float]] = {name: [0.0, 0.0] for name in truth}
    for part, constants in answer["constants"].items():
        for name, entry in constants.items():
            short = "inertia" if part == "machine" and name.endswith("inertia") else name
            if short in sums and entry.get("std") is not None:
                sums[short][0] += entry["value"]
                sums[short][1] += entry["std"]
    return {name: (value - truth[name]) / std for name, (value, std) in sums.items() if std > 0.0}


def _started(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([TWIN, *words], capture_output=True, text=True, check=False, timeout=LONGEST)

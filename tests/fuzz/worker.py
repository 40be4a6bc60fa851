"""A process that reads inputs of one kind, and notes what became of each: it may be ended by what it reads.

python -m tests.fuzz.worker KIND FOLDER --inputs 1000 --seed 1 [--guided]
"""

from __future__ import annotations

import argparse
import json
import mmap
import os
import random
import re
import resource
import struct
import sys
import time
import traceback
from pathlib import Path

from tests import ros_domain  # noqa: F401 - before ROS starts

LONGEST_TIME = 2.0
"""s of the processor's time that an input may take."""
LARGEST = 512 << 20
"""Bytes that the process may have in memory."""
LONGEST_LINE = 300  # beside the file's name
_ROOM = 1 << 30  # bytes, so that the machine survives what breaks the promise
COUNTS = ("inputs", "refused", "read", "not run")
"""What is counted of the inputs."""
_HEAD = struct.Struct("<QQ")  # inputs begun, and the length of the one that is being read
_GUIDING = ["ema_bench_replay"]  # the readers; numba would compile what is counted in the twin's package
_KEPT = 400  # inputs with a new outcome, as examples for more


class Worker:
    """Reads inputs and counts; what it is at stands in a file that outlives it."""

    def __init__(self, name: str, folder: Path, seed: int) -> None:
        from .kinds import KINDS
        from .mutations import LONGEST

        self.kind = KINDS[name]
        self.chance = random.Random(seed)
        self.folder = folder
        self.path = folder / f"input{self.kind.suffix}"
        (folder / "seeds").mkdir(exist_ok=True)
        self.examples = self.kind.seeds(folder / "seeds")
        self.read = self.kind.prepare(folder)
        with (folder / "now").open("w+b") as file:
            file.truncate(_HEAD.size + 2 * LONGEST)
            self.now = mmap.mmap(file.fileno(), 0)
        self.outcomes: set[str] = set()
        self.counts = dict.fromkeys(COUNTS, 0)
        self.faults: dict[str, str] = {}
        self.longest = 0.0

    def one(self, data: bytes) -> None:
        """Read one input."""
        from ema_bench_replay.errors import InputError

        from .kinds import NotRun, Unreadable

        self.path.write_bytes(data)
        self.counts["inputs"] += 1
        self.now[: _HEAD.size + len(data)] = _HEAD.pack(self.counts["inputs"], len(data)) + data
        begun = time.process_time()
        outcome = "read"
        try:
            self.read(self.path)
            self.counts["read"] += 1
        except InputError as error:
            outcome = self._refused(str(error), data)
            self.counts["refused"] += 1
        except Unreadable:
            self.counts["refused"] += 1
        except NotRun:
            self.counts["not run"] += 1
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            place = traceback.extract_tb(error.__traceback__)[-1]
            outcome = f"{type(error).__name__} in {Path(place.filename).name}:{place.name}"
            self._fault(outcome, data)
        taken = time.process_time() - begun
        self.longest = max(self.longest, taken)
        if taken > LONGEST_TIME:
            self._fault("takes longer than 2 s", data)
        if self.peak > LARGEST:
            self._fault("takes more than 512 MiB", data)
        if outcome not in self.outcomes and len(self.examples) < _KEPT:
            self.outcomes.add(outcome)
            self.examples.append(data)

    @property
    def peak(self) -> int:
        """Most bytes in memory so far; what getrusage tells begins with what the parent process had."""
        status = Path("/proc/self/status").read_text()
        return int(status.partition("VmHWM:")[2].split(maxsplit=1)[0]) << 10

    def _refused(self, message: str, data: bytes) -> str:
        line = f"error: {message}"
        if not line.isprintable():
            self._fault("a refusal holds what is no character of a line", data)
        if len(re.sub(re.escape(str(self.path.parent)) + r"[^\s:]*", "", line)) > LONGEST_LINE:
            self._fault(f"a refusal is longer than {LONGEST_LINE} characters", data)
        return re.sub(r"'.*'|\d+", "", message)

    def _fault(self, what: str, data: bytes) -> None:
        if what not in self.faults:
            file = self.folder / f"fault_{len(self.faults)}{self.kind.suffix}"
            file.write_bytes(data)
            self.faults[what] = str(file)

    def report(self) -> None:
        """Write what was found."""
        found = {**self.counts, "faults": self.faults, "longest": self.longest, "peak": self.peak}
        (self.folder / "report.json").write_text(json.dumps(found))

    def input_of(self, example: bytes) -> bytes:
        """A new input."""
        from .kinds import changed

        return changed(self.kind, example, self.chance.choice(self.examples), self.chance)

    def at_random(self, inputs: int) -> None:
        """Read inputs made of the examples, those that brought something new among them."""
        for example in tuple(self.examples):
            self.one(example)
        while self.counts["inputs"] < inputs:
            self.one(self.input_of(self.chance.choice(self.examples)))

    def guided(self, inputs: int, seed: int) -> None:
        """The same, led by the branches that each input takes first; does not come back."""
        import atheris

        corpus = self.folder / "corpus"
        corpus.mkdir(exist_ok=True)
        for number, example in enumerate(self.examples):
            (corpus / f"seed_{number}").write_bytes(example)

        def one(data: bytes) -> None:
            self.one(data)
            if self.counts["inputs"] >= inputs:
                self.report()
                os._exit(0)

        def change(data: bytes, longest: int, number: int) -> bytes:
            self.chance.seed(number)
            if self.chance.random() < 0.3:
                return atheris.Mutate(data, longest)
            return self.input_of(data or self.examples[0])[:longest]

        options = [f"-seed={seed}", "-rss_limit_mb=0", "-timeout=600", "-max_len=65536", "-print_final_stats=0"]
        atheris.Setup([sys.argv[0], *options, "-verbosity=0", str(corpus)], one, custom_mutator=change)
        atheris.Fuzz()


def main() -> None:
    """Read as many inputs as asked for, and write `report.json` into the folder."""
    parser = argparse.ArgumentParser()
    parser.add_argument("kind")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--inputs", type=int, required=True)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--guided", action="store_true")
    asked = parser.parse_args()
    resource.setrlimit(resource.RLIMIT_DATA, (_ROOM, _ROOM))
    if asked.guided:
        import atheris

        with atheris.instrument_imports(include=_GUIDING):
            worker = Worker(asked.kind, asked.folder, asked.seed)
        worker.guided(asked.inputs, asked.seed)
    worker = Worker(asked.kind, asked.folder, asked.seed)
    worker.at_random(asked.inputs)
    worker.report()


if __name__ == "__main__":
    main()
    sys.stdout.flush()
    os._exit(0)  # ROS was never started: nothing is to be taken leave of

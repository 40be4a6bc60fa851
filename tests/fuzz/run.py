"""``make fuzz``: random inputs for everything that reads what others wrote; none may break a promise.

A file is read, or refused in one line of at most 300 characters; no traceback, within 2 s, in 512 MiB.

python -m tests.fuzz.run [--inputs 100000] [--kinds CSV "MCAP zstd"] [--seed 1] [--guided] [--keep FOLDER]
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from .kinds import KINDS
from .worker import _HEAD, COUNTS

PATIENCE = 30.0
"""s of the processor's time without a new input after which a process is ended: a busy machine may keep it waiting."""
STANDSTILL = 1200.0
"""s without a new input after which it is ended although it takes no time."""


_interrupted = threading.Event()
"""Set where whoever asked has enough: no process is started any more."""


def read_inputs(name: str, folder: Path, inputs: int, seed: int, guided: bool = False) -> dict[str, Any]:
    """What became of so many inputs of one kind; a process that they end is followed by another, with another seed."""
    total = _nothing(0, {})
    while total["inputs"] < inputs and len(total["faults"]) < 20 and not _interrupted.is_set():
        place = folder / f"{name}_{seed}".replace(" ", "_")
        place.mkdir(parents=True, exist_ok=True)
        found = _process(name, place, inputs - total["inputs"], seed, guided)
        for count in COUNTS:
            total[count] += found[count]
        total["faults"] |= found["faults"]
        for most in ("longest", "peak"):
            total[most] = max(total[most], found[most])
        seed += 1000
    return total


def _process(name: str, folder: Path, inputs: int, seed: int, guided: bool) -> dict[str, Any]:
    words = [sys.executable, "-m", "tests.fuzz.worker", name, str(folder), "--inputs", str(inputs), "--seed", str(seed)]
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    with (folder / "said").open("w") as said:
        process = subprocess.Popen(
            [*words, *["--guided"] * guided], stdout=said, stderr=said, env=environment, cwd=Path(__file__).parents[2]
        )
        begun, since, took = 0, time.monotonic(), 0.0
        try:
            while process.poll() is None and not _interrupted.is_set():
                time.sleep(0.1)
                now = folder / "now"
                head = now.open("rb").read(_HEAD.size) if now.exists() else b""
                number = _HEAD.unpack(head)[0] if len(head) == _HEAD.size else 0
                spent, waited = _processor_time(process.pid) - took, time.monotonic() - since
                if number != begun:
                    begun, since, took = number, time.monotonic(), took + spent
                elif spent > PATIENCE + (300.0 if not begun else 0.0) or waited > STANDSTILL:
                    break
        finally:
            process.kill()
            process.wait()
    report = folder / "report.json"
    if process.returncode == 0 and report.exists():
        return json.loads(report.read_text())
    return _ended(folder, process.returncode)


def _processor_time(process: int) -> float:
    """s of the processor's time that a process has taken; 0 where it is gone."""
    try:
        fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _ended(folder: Path, status: int) -> dict[str, Any]:
    """What is known of a process that did not end by itself: the input that it was at."""
    now = folder / "now"
    if not now.exists():
        raise RuntimeError((folder / "said").read_text()[-2000:])
    data = now.read_bytes()
    inputs, length = _HEAD.unpack_from(data)
    file = folder / "ended_by"
    file.write_bytes(data[_HEAD.size : _HEAD.size + length])
    what = f"takes longer than {PATIENCE:.0f} s" if status == -signal.SIGKILL else f"ends the process ({status})"
    return _nothing(inputs, {what: str(file)})


def _nothing(inputs: int, faults: dict[str, str]) -> dict[str, Any]:
    """A report of so many inputs of which nothing else is known."""
    return {**dict.fromkeys(COUNTS, 0), "inputs": inputs, "faults": faults, "longest": 0.0, "peak": 0}


def main() -> int:
    """Read what was asked for and print a table; status 1 where anything broke a promise."""
    parser = argparse.ArgumentParser(prog="make fuzz", description=__doc__.partition("\n")[0])
    parser.add_argument("--inputs", type=int, default=20_000, help="of all kinds together")
    parser.add_argument("--kinds", nargs="+", default=list(KINDS), choices=list(KINDS), help="kinds of inputs")
    parser.add_argument("--seed", type=int, default=1, help="another number makes other inputs")
    parser.add_argument("--processes", type=int, default=os.cpu_count(), help="kinds at a time")
    parser.add_argument("--guided", action="store_true", help="led by coverage: needs atheris (pip install atheris)")
    parser.add_argument("--keep", type=Path, help="folder for inputs that broke a promise")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as made, ThreadPoolExecutor(asked.processes) as pool:
        folder = asked.keep or Path(made)
        each = -(-asked.inputs // len(asked.kinds))
        results = {name: pool.submit(read_inputs, name, folder, each, asked.seed, asked.guided) for name in asked.kinds}
        print("kind         inputs  refused     read  not run  faults  longest [s]  peak [MiB]")
        faults = {}
        try:
            for name, result in results.items():
                found = result.result()
                cells = "  ".join(f"{found[count]:7}" for count in COUNTS)
                print(
                    f"{name:10} {cells}  {len(found['faults']):6}  {found['longest']:11.2f}  {found['peak'] >> 20:10}",
                    flush=True,
                )
                faults |= {f"{name}: {what}": file for what, file in found["faults"].items()}
        except KeyboardInterrupt:
            _interrupted.set()
            pool.shutdown(cancel_futures=True)
            return 130
    for what, file in faults.items():
        print(f"  {what}" + (f": {file}" if asked.keep else ""))
    return 1 if faults else 0


if __name__ == "__main__":
    raise SystemExit(main())

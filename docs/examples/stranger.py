"""Recordings of a stranger's servo, to try `init` with: `python docs/examples/stranger.py NUMBER`.

Each number is another machine: its inertia from 1e-6 to 1e-2 kg m², its gear ratio from 1 to 200, sampled at 250 Hz to
8 kHz, with column names, units, delimiters and decimal marks of somebody's own, and with one hidden effect or none. It
writes three CSVs and, for those who want to look, `answer.json`.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from tests.accuracy.strangers.cases import stranger_cases


def write(number: int, folder: Path) -> list[Path]:
    """The recordings of one stranger's servo in this folder."""
    return stranger_cases(2026, number + 1)[number].write(folder)


if __name__ == "__main__":
    if len(sys.argv) != 2 or not sys.argv[1].isdigit():
        sys.exit("usage: python stranger.py NUMBER (0, 1, 2 …: each another machine)")
    for file in write(int(sys.argv[1]), Path()):
        print(file)

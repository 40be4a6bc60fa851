"""Columns whose names say that they number the runs of one file."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from ema_bench_replay.traces.header_words import header_words

_NUMBERS_RUNS = re.compile(r"run|sequence|seq|trial|attempt|experiment|repetition|lauf|messlauf|versuch|wiederholung")
_NUMBERS_TESTS = re.compile(r"tests?")


def run_columns(header: Sequence[str]) -> list[str]:
    """The columns of a header that are named like numbers of runs; tests, which may be of several runs, come last."""
    words = {name: header_words(name).words for name in header}
    return [
        name
        for pattern in (_NUMBERS_RUNS, _NUMBERS_TESTS)
        for name, of_name in words.items()
        if any(map(pattern.fullmatch, of_name))
    ]


def count_of_runs(values: np.ndarray) -> int:
    """How many runs a column (n,) numbers: its values, if the rows of each follow each other; 0 if they do not.

    Runs are numbered by whole numbers, and most have several rows: a temperature that rises with each row numbers none.
    """
    numbers, rows = np.unique(values, return_counts=True)
    follow = np.count_nonzero(np.diff(values)) == len(numbers) - 1
    return len(numbers) if follow and np.median(rows) > 1 and np.array_equal(values, np.rint(values)) else 0


def how_to_read_runs(column: str) -> str:
    """What reads each run of a file by itself, in words."""
    return f"with `run: {column}` in the import map, ema-twin campaign judges each run by itself"

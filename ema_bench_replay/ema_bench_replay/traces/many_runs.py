"""Many recordings from one text trace with columns for run and test."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import TEST, Recording
from ema_bench_replay.traces.import_map import ImportMap
from ema_bench_replay.traces.trace_csv import column_of, recording_of
from ema_bench_replay.traces.trace_table import read_table


def read_runs(path: str | Path, import_map: ImportMap) -> list[Recording]:
    """Read all runs of a trace, in the order of their first rows; a single one if the map names no run column.

    A run is named after its file and number, and has its test in the metadata. Raises InputError.
    """
    path = Path(path)
    table = read_table(path, import_map.delimiter, import_map.number_format, import_map.places)
    if import_map.run is None:
        return [recording_of(table, import_map)]
    numbers = column_of(table, import_map.run, " tells the run of a row")
    tests = None if import_map.test is None else column_of(table, import_map.test, " tells the test of a row")
    found = []
    for number in dict.fromkeys(numbers.tolist()):
        of_run = numbers == number
        recording = recording_of(table.without(np.flatnonzero(~of_run)), import_map)
        metadata = dict(recording.metadata)
        if tests is not None:
            labels = np.unique(tests[of_run])
            if len(labels) > 1:
                raise InputError(
                    f"{path}: run {number:g} is of tests {labels[0]:g} and {labels[1]:g}; number runs on from test to "
                    "test"
                )
            metadata[TEST] = f"{labels[0]:g}"
        found.append(replace(recording, name=f"{recording.name}_{number:g}", metadata=metadata))
    return found

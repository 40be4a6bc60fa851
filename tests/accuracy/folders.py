"""Cases as folders: ``train/*.CSV``, ``holdout/*.CSV`` and ``answer.json``."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path

import numpy as np

from ema_bench_replay.load import load
from ema_bench_replay.recording import Recording
from ema_bench_replay.traces.import_map import load_map
from ema_bench_replay.traces.trace_writer import write_trace

from .cases import Case
from .trace import with_jump

_SUMMED = ("coulomb_friction",)
"""Effects whose truth is the sum over two sides: no instance alone has it."""


def save(case: Case, folder: Path) -> Path:
    """Write a case as ``folder/NAME`` and return that."""
    place = folder / case.name
    siemens = load_map("siemens")
    for part, recordings in (("train", case.train), ("holdout", case.holdout)):
        random = np.random.default_rng((*case.seed, 2))
        for recording in recordings:
            traced = with_jump(recording, random) if case.unkind.counter_jump else recording
            write_trace(traced, place / part / f"{recording.name}.CSV", siemens, force=True)
    parameters = {id: values for id, values in case.parameters.items() if id not in _SUMMED}
    answer = {
        "hidden": list(case.hidden),
        "remove_from_stock_model": list(case.remove_from_stock_model),
        "parameters": parameters,
        "tolerated": list(case.tolerated),
        "causes": [{"id": c.id, "options": dict(c.options), "values": dict(c.values)} for c in case.causes],
        "kind": case.kind,
    }
    (place / "answer.json").write_text(json.dumps(answer, indent=1), "utf-8")
    return place


def readable_train(case: Case) -> tuple[Recording, ...]:
    """The training recordings, as a reader would give them."""
    if not case.unkind.counter_jump:
        return case.train
    with tempfile.TemporaryDirectory() as folder:
        return saved_and_read(case, Path(folder))


def saved_and_read(case: Case, folder: Path) -> tuple[Recording, ...]:
    """The training recordings, written and read again: as a trace with a counter's jump must come."""
    return tuple(load(path) for path in sorted((save(case, folder) / "train").glob("*.CSV")))

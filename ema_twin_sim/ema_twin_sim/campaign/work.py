"""Do one job, from its files to its rows in the store. Whatever happens, there is at least one row."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from datetime import datetime, timezone
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.load import load_runs
from ema_bench_replay.recording import NO_DATE, TEST, Recording

from ..health.motion_record import SPEED, MotionRecord
from ..health.run_features import run_features
from ..model import Model, load_model
from ..model.model_file import model_files
from ..version import VERSION
from .health_rows import health_row
from .jobs import HEALTH, Job, Task
from .results import DONE, FAILED, LEFT_OUT, REFUSED
from .turn_of_motor import turn_of_motor

_LEAST_SAMPLES = 2
_HASH_BYTES = 16

Row = dict[str, Any]


def judged(job: Job, task: Task, tell: Callable[[str], None] = lambda text: None) -> list[Row]:
    """The rows of a job: the findings, or why there are none; one row, or one for each run of a file that holds many.

    All have the job's key, and the time at which it was done. ``tell`` is called with what is wrong with the recordings
    themselves, which the rows have among their other warnings.
    """
    begun = time.perf_counter()
    row = blank(job, task.verb, task.model)
    recordings: list[Recording] = []
    left_out: list[str] = []
    with errors_told_in(row):
        recordings = _read(job, task, left_out)
    if job.apart and len(recordings) > 1:
        rows = [_judged(row | {"name": _run_name(job, one)}, [one], job, task) for one in recordings]
    else:
        rows = [_judged(row, recordings, job, task) if recordings else row]
    warnings = [*left_out, *(warning for recording in recordings for warning in recording.warnings)]
    if task.verb == HEALTH:
        warnings += [warning for one in rows for warning in one.get("warnings") or ()]
    for warning in dict.fromkeys(warnings):
        tell(warning)
    seconds = (time.perf_counter() - begun) / len(rows)
    at = datetime.now(timezone.utc)
    for row in rows if left_out else ():
        row["warnings"] = [*left_out, *(row.get("warnings") or [])]
    return [row | {"seconds": seconds, "done_at": at} for row in rows]


def _read(job: Job, task: Task, left_out: list[str]) -> list[Recording]:
    """The recordings of a job; of several, those that cannot be read are added to ``left_out``.

    Raises InputError if none can be read.
    """
    found, refused = [], []
    for parts in job.recordings:
        try:
            found += load_runs([*map(Path, parts)], import_map=task.import_map)
        except InputError as error:
            refused.append(error)
    if not found:
        raise refused[0]
    left_out += [f"{error}{LEFT_OUT}" for error in refused]
    return found


def _judged(row: Row, recordings: Sequence[Recording], job: Job, task: Task) -> Row:
    with errors_told_in(row):
        row |= _of_recordings(recordings)
        row["warnings"] = [warning for recording in recordings for warning in recording.warnings]
        if job.time is not None:
            row["time"] = job.time
        if short := [r.name for r in recordings if len(r) < _LEAST_SAMPLES]:
            raise InputError(f"{short[0]}: holds {_LEAST_SAMPLES - 1} sample; leave it out")
        model = _model(task.model, _modified(task.model)) if task.model else None
        if task.verb == HEALTH:
            row["health"] = _health(recordings[0], model, row, job, task)
        else:
            assert model is not None  # all verbs except health have one
            row |= _VERBS[task.verb](recordings, model, task.without)
        row["status"] = DONE
    return row


@contextmanager
def errors_told_in(row: Row) -> Iterator[None]:
    """Tell an error in the row, since one recording or point must not stop all others.

    Errors are of the input, of the machine that this runs on, such as of a disk, or of this package.
    """
    try:
        yield
    except InputError as error:
        row |= {"status": REFUSED, "message": str(error)}
    except OSError as error:
        place = "" if error.filename is None else f"{error.filename}: "
        row |= {"status": FAILED, "message": f"{place}{error.strerror or error}; run the command again to retry it"}
    except Exception as error:
        row |= {"status": FAILED, "message": f"internal error: {type(error).__name__}: {error}"}


def _run_name(job: Job, run: Recording) -> str:
    """Name of a run of a file that holds many: by its test, if the file has it, and its number."""
    number = run.name.rpartition("_")[2]
    test = f" test {run.metadata[TEST]}" if TEST in run.metadata else ""
    return f"{job.name}{test} run {number}"


def _health(recording: Recording, model: Model | None, row: Row, job: Job, task: Task) -> Row:
    """The features by which a recording's unit is judged."""
    record = MotionRecord.from_recording(recording, _test(recording, row, job))
    wavelength, unknown = task.wavelength, ""
    if wavelength is None or record.place == SPEED:  # an integrated speed does not say where a wave begins
        wavelength, unknown = turn_of_motor(record, model, recording)
    row["warnings"] += [unknown] if unknown else []
    return health_row(run_features(record, wavelength))


def _test(recording: Recording, row: Row, job: Job) -> str:
    """Name of the test (what was set up once): from the file, the path or the day; else each recording is a test."""
    if TEST in recording.metadata:
        return f"{job.name} test {recording.metadata[TEST]}"
    if job.test is not None:
        return job.test
    return row["name"] if row["time"] is None else f"{row['time']:%Y-%m-%d}"


def blank(job: Job, verb: str, model: str) -> Row:
    """The row of a job before anything is found."""
    return {
        "key": job.key,
        "unit": job.unit,
        "name": job.name,
        "task": verb,
        "model": model,
        "time": job.time,
        "done_at": datetime.now(timezone.utc),
        "version": VERSION,
    }


@lru_cache(maxsize=4)
def _model(name: str, modified: tuple[int, ...]) -> Model:
    return load_model(name)


def _modified(name: str) -> tuple[int, ...]:
    return tuple(file.stat().st_mtime_ns for file in model_files(name))


def _of_recordings(recordings: Sequence[Recording]) -> Row:
    starts = [recording.start for recording in recordings if recording.start != NO_DATE]
    motions = sorted({recording.motion for recording in recordings})
    return {
        "time": datetime.fromtimestamp(max(starts) * 1e-9, timezone.utc) if starts else None,
        "duration": sum(recording.duration for recording in recordings),
        "samples": sum(len(recording) for recording in recordings),
        "motion": " and ".join(motions),
        "signals": sorted(set.intersection(*({*recording.signals} for recording in recordings))),
        "content": [_content(recording) for recording in recordings],
    }


def _content(recording: Recording) -> str:
    """A hash of all samples: the same for a copy under another name."""
    found = hashlib.blake2b(np.ascontiguousarray(recording.stamps).tobytes(), digest_size=_HASH_BYTES)
    for name, values in recording.signals.items():
        found.update(name.encode())
        found.update(np.ascontiguousarray(values).tobytes())
    return found.hexdigest()


def _compared(recordings: Sequence[Recording], model: Model, without: Sequence[str]) -> Row:
    from ..comparison.beyond_noise import beyond_noise
    from ..comparison.compare import compare

    found = compare(recordings, model)
    beyond = _beyond(beyond_noise(found.input, found.overall))
    return {"errors": _errors(found.overall), "beyond_noise": beyond, "warnings": list(found.warnings)}


def _fitted(recordings: Sequence[Recording], model: Model, without: Sequence[str]) -> Row:
    from ..comparison.beyond_noise import beyond_noise
    from ..fitting.fit import fit_model

    found = fit_model(recordings, model)
    return {
        "errors": _errors(found.after),
        "beyond_noise": _beyond(beyond_noise(found.input, found.after)),
        "parameters": _numbers(found.parameters) + _numbers(found.constants),
        "warnings": [warning.message for warning in found.warnings],
    }


def _diagnosed(recordings: Sequence[Recording], model: Model, without: Sequence[str]) -> Row:
    from ..discovery.diagnose import weigh
    from ..discovery.discover import discover

    found = discover(recordings, model, without=without)
    causes = weigh(found)
    ranked = [{"effect": entry.effect, "probability": entry.probability} for entry in causes.ranking]
    others = [{"effect": "none", "probability": causes.none}, {"effect": "unknown", "probability": causes.unknown}]
    return _discovery(found) | {"causes": ranked + others}


def discovered(recordings: Sequence[Recording], model: Model, without: Sequence[str] = ()) -> Row:
    """What a model lacks, and the estimated numbers."""
    from ..discovery.discover import discover

    return _discovery(discover(recordings, model, without=without))


def _discovery(found: Any) -> Row:
    return {
        "verdict": found.verdict,
        "missing": list(found.added),
        "depends_on": list(found.depends_on),
        "errors": _errors(found.left),
        "beyond_noise": _beyond(found.beyond_noise),
        "parameters": _numbers(found.parameters) + _numbers(found.constants),
        "warnings": list(found.warnings),
    }


_VERBS = {"compare": _compared, "fit": _fitted, "diagnose": _diagnosed, "discover": discovered}


def _errors(signals: Mapping[str, Any]) -> list[Row]:
    return [
        {"signal": name, "rmse": error["rmse"], "noise_floor": error["noise_floor"], "unit": error["unit"]}
        for name, error in signals.items()
        if not error["driven"]
    ]


def _beyond(times: Mapping[str, float]) -> list[Row]:
    return [{"signal": name, "times": value} for name, value in times.items()]


def _numbers(by_owner: Mapping[str, Mapping[str, Any]]) -> list[Row]:
    return [
        {"owner": owner, "name": name, "value": held["value"], "std": held["std"], "unit": held["unit"]}
        for owner, entries in by_owner.items()
        for name, held in entries.items()
        if name not in ("effect", "options")
    ]

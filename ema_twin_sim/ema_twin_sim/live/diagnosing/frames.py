"""Messages between the monitor and the process that diagnoses for it: arrays and JSON, no executable content."""

from __future__ import annotations

import io
import json
import struct
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import IO, Any

import numpy as np

from ema_bench_replay.recording import Recording

_LENGTH = struct.Struct("<Q")
_GIVEN = ("model", "base", "effect_files")
_WHOLE = ("name", "start", "motor_angle_origin", "output_angle_origin")


@dataclass(frozen=True)
class Job:
    """What to judge."""

    model: str  # file of the model that the twin runs
    base: str  # file of the same model without what earlier diagnoses added
    effect_files: tuple[str, ...]
    recordings: tuple[Recording, ...]


@dataclass(frozen=True)
class Answer:
    """The result of a job: a diagnosis as `diagnose --json` writes it, or why there is none.

    `explanation` holds the entries of the ranking that together explain the recordings, including those applied before.
    `settings`, by path, turn the given model into the one that has them.
    """

    diagnosis: dict[str, Any] | None
    explanation: list[dict[str, Any]] = field(default_factory=list)
    settings: dict[str, bool | float | str] = field(default_factory=dict)
    refusal: str = ""


def send(stream: IO[bytes], message: Job | Answer) -> None:
    """Write a job or an answer. Raises BrokenPipeError if nobody reads."""
    arrays: dict[str, np.ndarray] = {}
    if isinstance(message, Job):
        words: dict[str, Any] = {"recordings": []}
        words |= {name: getattr(message, name) for name in _GIVEN}
        for number, recording in enumerate(message.recordings):
            arrays[f"{number} stamps"] = recording.stamps
            arrays |= {f"{number} {name}": values for name, values in recording.signals.items()}
            held = {name: getattr(recording, name) for name in _WHOLE}
            words["recordings"].append({**held, "metadata": dict(recording.metadata)})
    else:
        words = asdict(message)
    packed = io.BytesIO()
    np.savez(packed, allow_pickle=False, words=np.array(json.dumps(words)), **arrays)
    content = packed.getbuffer()
    stream.write(_LENGTH.pack(len(content)))
    stream.write(content)
    stream.flush()


def receive_job(stream: IO[bytes]) -> Job | None:
    """The next job; None if the stream has ended."""
    received = _receive(stream)
    if received is None:
        return None
    words, arrays = received
    recordings = [
        Recording(**held, stamps=arrays[f"{k} stamps"], signals=_signals(arrays, f"{k} "))
        for k, held in enumerate(words["recordings"])
    ]
    return Job(words["model"], words["base"], tuple(words["effect_files"]), tuple(recordings))


def receive_answer(stream: IO[bytes]) -> Answer | None:
    """The next answer; None if the stream has ended."""
    received = _receive(stream)
    return None if received is None else Answer(**received[0])


def _receive(stream: IO[bytes]) -> tuple[dict[str, Any], dict[str, np.ndarray]] | None:
    head = stream.read(_LENGTH.size)
    if len(head) < _LENGTH.size:
        return None
    (length,) = _LENGTH.unpack(head)
    content = stream.read(length)
    if len(content) < length:
        return None
    with np.load(io.BytesIO(content), allow_pickle=False) as held:
        arrays = {name: held[name] for name in held.files}
    return json.loads(str(arrays.pop("words"))), arrays


def _signals(arrays: dict[str, np.ndarray], prefix: str) -> dict[str, np.ndarray]:
    names: Sequence[str] = [name for name in arrays if name.startswith(prefix) and name != f"{prefix}stamps"]
    return {name.removeprefix(prefix): arrays[name] for name in names}

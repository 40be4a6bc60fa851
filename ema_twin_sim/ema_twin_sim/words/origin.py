"""What a written result was computed from, so that a page does not tell it of another machine."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ema_bench_replay.errors import InputError

from ..listing import few_of, listed
from ..model import Model


@dataclass(frozen=True)
class Origin:
    """Names of the model, of its machine and of the recordings that a result was computed from."""

    model: str
    machine: str
    recordings: tuple[str, ...]

    def differs(self, recordings: Sequence[str]) -> bool:
        """Whether these recordings are others than those of the result, or not all of them."""
        return not (_all_in(self.recordings, recordings) and _all_in(recordings, self.recordings))

    def sentence(self, what: str) -> str:
        """What was used: ``The search used the recordings a and b.``"""
        one = "recording" if len(self.recordings) == 1 else "recordings"
        return f"The {what} used the {one} {few_of(self.recordings)}, and model {self.model}."


def read_origin(content: Mapping[str, Any]) -> Origin | None:
    """The origin from a result's JSON; None if the file does not tell it, as those of 0.1.0 do not."""
    if "machine" not in content or "recordings" not in content:
        return None
    return Origin(str(content["model"]), str(content["machine"]), texts(content["recordings"]))


def texts(values: Any) -> tuple[str, ...]:
    """A list of texts from a file. Raises ValueError if it is a single one."""
    if isinstance(values, str):
        raise ValueError(f"{values!r} is no list")
    return tuple(str(value) for value in values)


def refuse_foreign(
    option: str, path: Path, origin: Origin | None, models: Sequence[Model], names: Iterable[str]
) -> None:
    """Raise InputError if a result (``path``, given by ``option``) is of another machine, or of other recordings.

    A model that was renamed is known by its machine. ``names`` are those of the recordings given.
    """
    if origin is None:
        return
    given = tuple(names)
    advice = f"give the result for these, or leave out {option}"
    if origin.model not in {model.name for model in models} and origin.machine not in {m.machine for m in models}:
        told = listed(dict.fromkeys(model.name for model in models))
        raise InputError(
            f"{path}: is the result for model {origin.model} of machine {origin.machine}, but the models given are "
            f"{told}; {advice}"
        )
    if not any(_is_in(name, given) for name in origin.recordings):
        raise InputError(
            f"{path}: was computed from {few_of(origin.recordings)}, but the recordings given are {few_of(given)}; "
            f"{advice}"
        )


def _is_in(name: str, names: Sequence[str]) -> bool:
    """Whether a recording is one of others; to tell equal names apart, a folder may follow: ``run (monday)``."""
    return any(name == other or name.startswith(f"{other} (") or other.startswith(f"{name} (") for other in names)


def _all_in(names: Sequence[str], others: Sequence[str]) -> bool:
    return all(_is_in(name, others) for name in names)

"""The parameters to set on a running twin so that it gets the effects of a diagnosis. No ROS."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ema_bench_replay.errors import InputError

from ...listing import number_of
from ...model.model import ENABLED, nearest
from ...quantities import estimate
from .frames import Answer

Setting = bool | float | str


class NotDiagnosed(InputError):
    """Effects were to be applied before any diagnosis."""


class Busy(InputError):
    """A diagnosis, or what it found, is still being computed or set."""


def settings_for(answer: Answer, effects: Sequence[str]) -> tuple[dict[str, Setting], str]:
    """The twin's parameters to set, by path, and the same in words.

    Effects in the complete explanation get their values from it; any other effect gets those that it has alone. Without
    `effects`, the whole explanation is set, including the machine's constants that it changed.

    Raises InputError if the diagnosis found nothing, or does not have one of the effects.
    """
    assert answer.diagnosis is not None
    found, ranking = answer.explanation, answer.diagnosis["ranking"]
    if not effects:
        if not answer.settings:
            raise InputError(f"the last diagnosis found nothing to add (its verdict: {answer.diagnosis['verdict']})")
        return dict(answer.settings), "; ".join([_words(found), *_refitted(answer)])
    settings: dict[str, Setting] = {}
    chosen = []
    for id in dict.fromkeys(effects):
        entry = next((entry for entry in [*found, *ranking] if entry["effect"] == id), None)
        if entry is None:
            known = tuple(dict.fromkeys(entry["effect"] for entry in ranking))
            hint = nearest(id, known) if known else "it is empty"
            raise InputError(f"the last diagnosis has no effect '{id}'; {hint}")
        start = f"effects.{entry['instance']}."
        held = {path: value for path, value in answer.settings.items() if path.startswith(start)}
        settings |= held or _alone(entry)
        chosen.append(entry)
    return settings, _words(chosen)


def _alone(entry: Mapping[str, Any]) -> dict[str, Setting]:
    values = {name: held["value"] for name, held in entry["parameters"].items() if held["value"] is not None}
    held = {**entry["options"], **values, ENABLED: True}
    return {f"effects.{entry['instance']}.{word}": value for word, value in held.items()}


def _words(entries: Sequence[Mapping[str, Any]]) -> str:
    return "; ".join(" ".join(_word(entry)) for entry in entries)


def _refitted(answer: Answer) -> list[str]:
    """How many other numbers change: the machine's, and those of effects that it has already."""
    own = tuple(f"effects.{entry['instance']}." for entry in answer.explanation)
    count = sum(not path.startswith(own) for path in answer.settings)
    return [f"and {number_of(count, 'constant')} refitted"] if count else []


def _word(entry: Mapping[str, Any]) -> list[str]:
    options = [f"{name} {choice}" for name, choice in entry["options"].items()]
    numbers = [f"{name} {estimate(p['value'], p['std'], p['unit'])}" for name, p in entry["parameters"].items()]
    return [entry["effect"], *options, *numbers]

"""YAML files with every value checked, so that a mistake in one is named with its file, its place and its remedy."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import yaml

from ema_bench_replay.errors import InputError


def read_yaml(path: Path) -> tuple[Any, str]:
    """Content and text of a YAML file. Raises InputError where it cannot be read or is no YAML."""
    try:
        text = path.read_text(encoding="utf-8")
        return yaml.safe_load(text), text
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read ({error}); give a YAML file in UTF-8") from None
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        place = f"line {mark.line + 1}: " if mark else ""
        problem = getattr(error, "problem", None) or "it does not parse"
        raise InputError(f"{path}: {place}is no YAML: {problem}; correct it") from None


class Checker:
    """Checks values of one file. Every method returns the value it was given, or raises InputError.

    `place` says where in the file the value stands, for instance `signals.current.unit`.
    """

    def __init__(self, path: Path) -> None:
        """Take the file's path, for the messages."""
        self.path = path

    def mapping(
        self, value: Any, place: str, allowed: Iterable[str], required: Iterable[str] = ()
    ) -> Mapping[str, Any]:
        """A mapping with no key but the allowed ones, and with all that are required."""
        allowed, required = list(allowed), list(required)
        if not isinstance(value, dict):
            raise self.error(place, "is no mapping of keys to values", f"give {', '.join(required or allowed)}")
        for key in value:
            if key not in allowed:
                near = get_close_matches(str(key), allowed, n=1)
                hint = f"did you mean {near[0]!r}?" if near else f"use one of {', '.join(allowed)}"
                raise self.error(place, f"unknown key {key!r}", hint)
        for key in required:
            if key not in value:
                raise self.error(place, f"the key {key!r} is missing", "add it")
        return value

    def choice(self, value: Any, place: str, allowed: Iterable[Any]) -> Any:
        """One of the allowed values."""
        allowed = list(allowed)
        if value not in allowed:
            near = get_close_matches(str(value), map(str, allowed), n=1)
            hint = f"did you mean {near[0]!r}?" if near else f"use one of {', '.join(map(str, allowed))}"
            raise self.error(place, f"{value!r} is not possible", hint)
        return value

    def number(self, value: Any, place: str, lower: float = -math.inf, upper: float = math.inf) -> float:
        """A finite number, as float, from `lower` to `upper`."""
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            raise self.error(place, f"{value!r} is no number", "give one (YAML wants 1.0e-3, not 1e-3)")
        if not lower <= value <= upper:
            raise self.error(place, f"{value!r} is out of range", f"give a number from {lower:g} to {upper:g}")
        return float(value)

    def text(self, value: Any, place: str) -> str:
        """A text that is not empty."""
        if not isinstance(value, str) or not value:
            raise self.error(place, f"{value!r} is no text", "give one, in quotation marks if need be")
        return value

    def error(self, place: str, wrong: str, remedy: str) -> InputError:
        """The error for a place of this file, to raise."""
        where = f"{place}: " if place else ""
        return InputError(f"{self.path}: {where}{wrong}; {remedy}")

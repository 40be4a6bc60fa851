"""Read YAML files and check every value; an error message names the file, the place and the remedy."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from contextlib import suppress
from difflib import get_close_matches
from itertools import pairwise
from pathlib import Path
from typing import Any

import yaml

from ema_bench_replay.errors import InputError

_READ_OTHERWISE = re.compile(r"[\t?!\ufeff]|[|>][-+0-9]*#")  # libyaml and PyYAML disagree on some of these
_DIGITS = re.compile(r"\d+([eE][-+]?\d+)?")
_WITH_COMMA = re.compile(r"\s*([-+]?\d+),(\d+([eE][-+]?\d+)?)\s*")  # a number with a decimal comma
_LARGEST = 1 << 20  # bytes; hand-written files have a few thousand
_MOST_NODES = 100_000  # keys and values with every alias expanded; hand-written files have some hundred


def read_yaml(path: Path, remedy: str = "give a YAML file in UTF-8") -> tuple[Any, str]:
    """Content and text of a YAML file; keys are unique and every integer fits a float.

    Raises InputError if it cannot be read (with the `remedy`) or is not YAML.
    """
    try:
        with path.open("rb") as file:
            data = file.read(_LARGEST + 1)
        text = data.decode("utf-8")
    except UnicodeDecodeError:
        raise InputError(f"{path}: is no text in UTF-8; {remedy}") from None
    except (OSError, ValueError) as error:  # ValueError: a path that no file can have
        reason = getattr(error, "strerror", None) or error
        name = str(path) if str(path).isprintable() else repr(str(path))
        raise InputError(f"{name}: cannot be read ({reason}); {remedy}") from None
    if len(data) > _LARGEST:
        raise InputError(f"{path}: is larger than 1 MiB; {remedy}")
    try:
        return parse_yaml(text), text
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        place = f"line {mark.line + 1}: " if mark else ""
        problem = getattr(error, "problem", None) or "it does not parse"
        if isinstance(error, _DecimalComma):
            raise InputError(f"{path}: {place}{problem}") from None
        raise InputError(f"{path}: {place}is no YAML: {problem}; correct it") from None
    except RecursionError:
        raise InputError(f"{path}: is nested too deeply; correct it") from None
    except ValueError as error:  # a date or a number that only looks like one
        raise InputError(f"{path}: holds a value that cannot be read ({error}); correct it") from None


def parse_yaml(text: str) -> Any:
    """The content of a YAML text. Text that libyaml refuses is parsed again by PyYAML, whose error messages are shown.

    Raises YAMLError, RecursionError or ValueError if it is not YAML, or would expand without bound.
    """
    if yaml.__with_libyaml__ and not _READ_OTHERWISE.search(text):
        with suppress(yaml.YAMLError, RecursionError, ValueError):
            return _QuickLoader(text).get_single_data()
    return _Loader(text).get_single_data()


def _count(node: yaml.Node, counted: dict[int, int]) -> int:
    """Number of nodes with every alias expanded. Raises ComposerError if there are too many."""
    if id(node) in counted:
        if not counted[id(node)]:
            raise yaml.composer.ComposerError(None, None, "it contains itself", node.start_mark)
        return counted[id(node)]
    counted[id(node)] = 0  # unknown until its children are counted
    children = () if isinstance(node, yaml.ScalarNode) else node.value
    if isinstance(node, yaml.MappingNode):
        children = [one for pair in node.value for one in pair]
    total = 1 + sum(_count(child, counted) for child in children)
    if total > _MOST_NODES:
        raise yaml.composer.ComposerError(None, None, "its aliases make it too large", node.start_mark)
    counted[id(node)] = total
    return total


class _DecimalComma(yaml.composer.ComposerError):
    """A number with a decimal comma in a mapping in braces, where the comma ends the value."""


def decimal_comma(value: object) -> str:
    """What is wrong with a text that is a number with a decimal comma, and what to do; empty for all else."""
    return _said_of_comma(value.strip()) if isinstance(value, str) and _WITH_COMMA.fullmatch(value) else ""


def _refuse_decimal_comma(pairs: list[tuple[yaml.Node, yaml.Node]]) -> None:
    """Raise _DecimalComma if a key of digits without a value follows a value of digits, as ``value: 0,052`` reads."""
    for (_, before), (key, after) in pairwise(pairs):
        plain = isinstance(before, yaml.ScalarNode) and isinstance(key, yaml.ScalarNode) and not key.style
        if not plain or not isinstance(after, yaml.ScalarNode) or after.value:
            continue
        number = f"{before.value},{key.value}"
        if _DIGITS.fullmatch(key.value) and _WITH_COMMA.fullmatch(number):
            raise _DecimalComma(None, None, _said_of_comma(number), key.start_mark)


def _said_of_comma(number: str) -> str:
    """What is wrong with a number with a decimal comma; and after a semicolon, what to do."""
    return f"{number} has a decimal comma; write {number.replace(',', '.')}, with a point"


class _Loader(yaml.SafeLoader):
    """PyYAML's safe loader, but it refuses duplicate keys and unbounded aliases."""

    def get_single_node(self) -> yaml.Node | None:
        node = super().get_single_node()
        if node is not None:
            _count(node, {})
        return node

    def construct_object(self, node: yaml.Node, deep: bool = False) -> Any:
        try:
            return super().construct_object(node, deep=deep)
        except (LookupError, AttributeError):  # the value does not match its tag
            wrong = f"this is no {node.tag.rpartition(':')[2]}"
            raise yaml.constructor.ConstructorError(None, None, wrong, node.start_mark) from None

    def compose_mapping_node(self, anchor: Any) -> yaml.MappingNode:
        node = super().compose_mapping_node(anchor)
        seen = set()
        for key, _ in node.value:
            if isinstance(key, yaml.ScalarNode):
                if (key.tag, key.value) in seen:
                    raise yaml.composer.ComposerError(
                        None, None, f"the key {key.value!r} is there twice", key.start_mark
                    )
                seen.add((key.tag, key.value))
        _refuse_decimal_comma(node.value)
        return node

    def construct_yaml_int(self, node: yaml.ScalarNode) -> int:
        value = super().construct_yaml_int(node)
        try:
            float(value)
        except OverflowError:
            raise yaml.constructor.ConstructorError(None, None, "a number is too large", node.start_mark) from None
        return value


_Loader.add_constructor("tag:yaml.org,2002:int", _Loader.construct_yaml_int)

if yaml.__with_libyaml__:

    class _QuickLoader(yaml.CSafeLoader, _Loader):
        """The same with libyaml's parser: about six times as fast."""

        get_single_node = _Loader.get_single_node  # libyaml's own would not notice duplicate keys

        def __init__(self, text: str) -> None:
            _Loader.__init__(self, "")
            yaml.CSafeLoader.__init__(self, text)


class Checker:
    """Checks values of one file. Every method returns the given value, or raises InputError.

    `place` is the value's place in the file, for instance `signals.current.unit`.
    """

    def __init__(self, path: Path) -> None:
        """Take the file's path, for the messages."""
        self.path = path

    def mapping(
        self, value: Any, place: str, allowed: Iterable[str] | None = None, required: Iterable[str] = ()
    ) -> Mapping[str, Any]:
        """Check that it is a mapping with only allowed keys (None: any) and all required ones."""
        known, required = list(allowed or ()), list(required)
        if not isinstance(value, dict):
            wanted = ", ".join(required or known) or "NAME: VALUE"
            raise self.error(place, "is no mapping of keys to values", f"give {wanted}")
        for key in value if allowed is not None else ():
            if key not in known:
                near = get_close_matches(str(key), known, n=1)
                hint = f"did you mean {near[0]!r}?" if near else f"use one of {', '.join(known)}"
                raise self.error(place, f"unknown key {key!r}", hint)
        for key in required:
            if key not in value:
                raise self.error(place, f"the key {key!r} is missing", "add it")
        return value

    def choice(self, value: Any, place: str, allowed: Iterable[Any]) -> Any:
        """Check that it is one of the allowed values; true and false do not count as numbers."""
        allowed = list(allowed)
        if isinstance(value, bool) or value not in allowed:
            near = get_close_matches(str(value), map(str, allowed), n=1)
            hint = f"did you mean {near[0]!r}?" if near else f"use one of {', '.join(map(str, allowed))}"
            raise self.error(place, f"{value!r} is not possible", hint)
        return value

    def number(self, value: Any, place: str, lower: float = -math.inf, upper: float = math.inf) -> float:
        """Check that it is a finite number from `lower` to `upper`; returned as float."""
        if said := decimal_comma(value):
            raise InputError(f"{self.path}: {place}: {said}")
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            raise self.error(place, f"{value!r} is no number", "give one (YAML wants 1.0e-3, not 1e-3)")
        if not lower <= value <= upper:
            raise self.error(place, f"{value!r} is out of range", f"give a number from {lower:g} to {upper:g}")
        return float(value)

    def boolean(self, value: Any, place: str) -> bool:
        """Check that it is true or false."""
        if not isinstance(value, bool):
            raise self.error(place, f"{value!r} is neither true nor false", "give one of them, without quotation marks")
        return value

    def text(self, value: Any, place: str) -> str:
        """Check that it is a text that is not empty."""
        if not isinstance(value, str) or not value:
            raise self.error(place, f"{value!r} is no text", "give one, in quotation marks if need be")
        return value

    def error(self, place: str, wrong: str, remedy: str) -> InputError:
        """The error for a place of this file, to raise."""
        where = f"{place}: " if place else ""
        return InputError(f"{self.path}: {where}{wrong}; {remedy}")

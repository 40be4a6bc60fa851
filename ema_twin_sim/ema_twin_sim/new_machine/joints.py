"""Columns of several joints in one trace, as robots log them: the columns of one joint are taken, since a search judges
one joint.

Joints are distinguished by a number in the names, as in ``q1 … q6`` or ``pos (3)``. Two numbered shafts that move
together are motor and output of one drive train.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ema_bench_replay.traces.header_words import HeaderWords
from ema_bench_replay.units import MOTIONS, units_of

from ..criteria import SMALL

_DRIVES = frozenset({"current", "torque"})
_MOVES = ("position", "speed")


@dataclass(frozen=True)
class Joint:
    """The number of the joint whose columns are taken, and those of the others; empty if there is only one joint."""

    number: str = ""
    others: tuple[str, ...] = ()

    @property
    def sentence(self) -> str:
        """Which joint was chosen and why, and how to choose another."""
        return (
            f"the columns numbered {self.number}, of the joint with the largest motion; those of "
            f"{', '.join(self.others)} are not used (to use another joint, remove the others' columns and run init "
            "again)"
        )


ONE_JOINT = Joint()


@dataclass(frozen=True)
class Numbered:
    """A column's name, what it measures, and whether it is a setpoint."""

    read: HeaderWords
    quantity: str | None
    setpoint: bool


def one_joint(
    columns: Sequence[Numbered], numbers: Mapping[str, np.ndarray], wanted: str = ""
) -> tuple[Joint, list[HeaderWords]]:
    """Choose one joint; return it with the names of its columns (without its number) and of those of no joint.

    ``numbers`` are the columns' values, (n,) each; ``wanted`` is the joint taken in another trace of the same machine.
    """
    names = [column.read for column in columns]
    joints = _joints(columns, numbers)
    if len(joints) < 2 or any(_one_train(a, b, numbers) for a, b in _pairs(joints)):
        return ONE_JOINT, names
    chosen = wanted if wanted in joints else max(joints, key=lambda number: travel(joints[number], numbers))
    others = frozenset(joints) - {chosen}
    kept = [
        replace(read, words=tuple(word for word in read.words if word != chosen))
        for read in names
        if not others & {*_numbers_in(read)}
    ]
    return Joint(chosen, tuple(number for number in joints if number in others)), kept


def _joints(columns: Sequence[Numbered], numbers: Mapping[str, np.ndarray]) -> dict[str, HeaderWords]:
    """The column with the motion of each joint, by number; a joint has both a current or torque and a motion.

    A command of the current or torque counts if none was measured.
    """
    found: dict[str, dict[str, HeaderWords]] = {}
    commanded = not any(column.quantity in _DRIVES and not column.setpoint for column in columns)
    for column in columns:
        digits = _numbers_in(column.read)
        if column.setpoint and not (commanded and column.quantity in _DRIVES):
            continue
        if len(digits) == 1 and column.quantity and column.read.name in numbers:
            found.setdefault(digits[0], {}).setdefault(column.quantity, column.read)
    return {
        number: held.get("position", held.get("speed", next(iter(held.values()))))
        for number, held in found.items()
        if _DRIVES & held.keys() and any(move in held for move in _MOVES)
    }


def _numbers_in(read: HeaderWords) -> list[str]:
    """The numbers in a column's name, including one in brackets."""
    return [word for word in (*read.words, read.foreign) if word.isdigit()]


def _pairs(joints: Mapping[str, HeaderWords]) -> list[tuple[HeaderWords, HeaderWords]]:
    reads = list(joints.values())
    return [(one, other) for place, one in enumerate(reads) for other in reads[place + 1 :]]


def travel(read: HeaderWords, numbers: Mapping[str, np.ndarray]) -> float:
    """The range of a position, in SI units if its name has a unit."""
    known = {unit: size for motion in MOTIONS for unit, size in units_of("motor_position", motion).items()}
    values = numbers[read.name]
    return float(np.ptp(values[np.isfinite(values)])) * known.get(read.unit or "", 1.0)


def _one_train(one: HeaderWords, other: HeaderWords, numbers: Mapping[str, np.ndarray]) -> bool:
    """Whether nearly all of one motion is that of the other; less is not enough, since two joints may move in step."""
    return math.sqrt(1.0 - likeness(numbers[one.name], numbers[other.name]) ** 2) < SMALL


def likeness(one: np.ndarray, other: np.ndarray) -> float:
    """Absolute correlation of two motions (n,): 1 if they always go the same way, or always against each other."""
    both = np.isfinite(one) & np.isfinite(other)
    ways = [values[both] - values[both].mean() for values in (one, other)]
    size = math.sqrt(float(ways[0] @ ways[0]) * float(ways[1] @ ways[1]))
    return min(1.0, abs(float(ways[0] @ ways[1])) / size) if size > 0.0 else 0.0

"""Columns of several joints in one trace, as robots log them: the columns of one joint are taken, since a search judges
one joint.

Joints are distinguished by a number in the names, as in ``q1 … q6`` or ``pos (3)``, or by words and letters, as in
``left_hip_torque`` or ``X_position``. Two shafts that move together are motor and output of one drive train.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ema_bench_replay.some_of import some_of
from ema_bench_replay.traces.header_words import HeaderWords
from ema_bench_replay.units import MOTIONS, units_of

from ..criteria import NEGLIGIBLE, PART, SMALL
from ..measured.exact_factor import exact_factor
from .column_quantity import has_word
from .column_words import TOOL
from .part_names import part_in_the_name, part_of, without_type

_DRIVES = frozenset({"current", "torque"})
_MOVES = ("position", "speed")
_SHAFTS = 2  # of a drive train: the motor's and the output's

Part = tuple[str, ...]
"""The words, or the number, by which a column's name tells its joint; empty if it tells none."""


@dataclass(frozen=True)
class Joint:
    """The number or name of the joint whose columns are taken, and those of the others; empty if there is only one.

    ``undriven`` are those that go farther, but whose current or torque never changes; ``moving`` those of the others
    that go a considerable part as far; ``same`` those that only tell the same drive again.
    """

    name: str = ""
    others: tuple[str, ...] = ()
    undriven: tuple[str, ...] = ()
    moving: tuple[str, ...] = ()
    same: tuple[str, ...] = ()

    @property
    def sentence(self) -> str:
        """Which joint was chosen and why, and how to choose another."""
        which = f"numbered {self.name}, of" if self.name.isdigit() else f"of {self.name},"
        why = "the joint with the largest motion"
        if self.undriven:
            why += f" of those whose current or torque changes (that of {some_of(self.undriven)} never does)"
        return (
            f"the columns {which} {why}; those of {some_of(self.others)} are not used "
            f"(to use another joint, remove the others' columns and run init again){self._beside_it}"
        )

    @property
    def _beside_it(self) -> str:
        """What tells the same drive again, and what joints that move beside it do to it; empty if nothing does."""
        if self.same:
            tell = "tells" if len(self.same) == 1 else "tell"
            again = f"; {some_of(self.same)} {tell} the same drive again, in other units or at another shaft"
            return again + replace(self, same=())._beside_it
        if not self.moving:
            return ""
        move = "moves" if len(self.moving) == 1 else "move"
        return (
            f"; {some_of(self.moving)} {move} too: what hangs on this joint acts on it by weight and inertia, which "
            "discover may take for another load; record this joint alone"
        )


ONE_JOINT = Joint()


@dataclass(frozen=True)
class JointColumn:
    """A column's name, what it measures, and whether it is a setpoint."""

    read: HeaderWords
    quantity: str | None
    setpoint: bool


def one_joint(
    columns: Sequence[JointColumn], numbers: Mapping[str, np.ndarray], wanted: str
) -> tuple[Joint, list[HeaderWords]]:
    """Choose one joint; return it with the names of its columns (without its own) and of those of no joint.

    ``numbers`` are the columns' values, (n,) each; ``wanted`` is the joint taken in another trace of the same machine.
    """
    columns = _without_tool(columns, numbers)
    numbered, worded = _Parts(columns, numbers, _by_number(columns)), _Parts(columns, numbers, _by_words(columns))
    by_number = len(worded.joints) <= len(numbered.joints)  # names that number all alike need not agree in their words
    parts = numbered if by_number else worded
    joints = parts.joints
    driven_apart = parts.have_motors_of_their_own()
    if len(joints) < 2 or (not driven_apart and _are_one_train([*joints.values()], numbers, by_number)):
        return ONE_JOINT, [column.read for column in columns]
    known = {part_in_the_name(part, read.name): part for part, read in joints.items()}
    ways = {name: travel(joints[part], numbers) for name, part in known.items()}
    driven = {name for name, part in known.items() if parts.is_driven(part)}
    again = _told_again({name: parts.measured(part) for name, part in known.items()})
    farthest = {name: max(ways[other] for other in (name, *again[name])) for name in known}
    worths = {name: (name in driven, farthest[name], parts.has_current(known[name]), ways[name]) for name in known}
    chosen = wanted if wanted in known else max(known, key=worths.__getitem__)
    undriven = tuple(name for name in known if name not in driven and chosen in driven and ways[name] > ways[chosen])
    own, others = known[chosen], [part for name, part in known.items() if name != chosen]
    own_first = sorted(columns, key=lambda column: parts.by_name[column.read.name] != own)
    kept = [
        replace(column.read, words=tuple(word for word in column.read.words if word not in own))
        for column in own_first
        if not _is_of_others(parts.by_name[column.read.name], own, others)
        and (by_number or not _is_elsewhere(column, parts.by_name[column.read.name], own))
    ]
    same = again[chosen]
    moving = tuple(name for name in known if name not in (chosen, *same) and ways[name] > PART * ways[chosen])
    return Joint(chosen, tuple(name for name in known if name != chosen), undriven, moving, same), kept


@dataclass(frozen=True)
class _Parts:
    """Columns of a trace, their values (n,) by name, and the part of the machine that each name tells."""

    columns: Sequence[JointColumn]
    numbers: Mapping[str, np.ndarray]
    by_name: Mapping[str, Part]

    @cached_property
    def joints(self) -> dict[Part, HeaderWords]:
        """The column with the motion of each joint, by its part; a joint has both a current or torque and a motion.

        A command of the current or torque counts if none was measured.
        """
        found: dict[Part, dict[str, HeaderWords]] = {}
        commanded = not any(column.quantity in _DRIVES and not column.setpoint for column in self.columns)
        for column in self.columns:
            if column.setpoint and not (commanded and column.quantity in _DRIVES):
                continue
            part = self.by_name[column.read.name]
            if part and column.quantity and column.read.name in self.numbers:
                found.setdefault(part, {}).setdefault(column.quantity, column.read)
        return {
            part: held.get("position", held.get("speed", next(iter(held.values()))))
            for part, held in found.items()
            if _DRIVES & held.keys() and any(move in held for move in _MOVES)
        }

    def of(self, part: Part, quantities: Collection[str]) -> list[JointColumn]:
        """The columns of a part with these quantities and with values."""
        own = (column for column in self.columns if self.by_name[column.read.name] == part)
        return [column for column in own if column.read.name in self.numbers and column.quantity in quantities]

    def measured(self, part: Part) -> dict[str, np.ndarray]:
        """By its quantity, the first column (n,) that a part measures of it."""
        own = [column for column in reversed(self.of(part, (*_MOVES, *_DRIVES))) if not column.setpoint]
        return {column.quantity or "": self.numbers[column.read.name] for column in own}

    def drives(self, part: Part) -> list[JointColumn]:
        """The measured currents of a joint, or else its measured torques, or else the commands of either."""
        own = self.of(part, _DRIVES)
        measured = [column for column in own if not column.setpoint]
        return [column for column in measured if column.quantity == "current"] or measured or own

    def is_driven(self, part: Part) -> bool:
        """Whether a current of a joint changes, or else a torque: one that another moves has none to be judged."""
        return any(_changes(self.numbers[column.read.name]) for column in self.drives(part))

    def has_current(self, part: Part) -> bool:
        """Whether a joint's current is known, and not only its torque."""
        return any(column.quantity == "current" for column in self.drives(part))

    def have_motors_of_their_own(self) -> bool:
        """Whether two joints are driven by currents that change, or more of them than a train has shafts.

        Robots move their joints to a pose in step, however far each goes: motions alone do not tell joints from shafts.
        """
        driven = [part for part in self.joints if self.is_driven(part)]
        return sum(map(self.has_current, driven)) > 1 or len(driven) > _SHAFTS


def _told_again(measured: Mapping[str, Mapping[str, np.ndarray]]) -> dict[str, tuple[str, ...]]:
    """For each joint by its name, the others that tell the same drive; of each, what was measured by its quantity.

    A log may hold a drive's own units and those of its output, both computed from one encoder and one current.
    """
    return {
        name: tuple(other for other, theirs in measured.items() if other != name and _are_of_one_drive(own, theirs))
        for name, own in measured.items()
    }


def _are_of_one_drive(one: Mapping[str, np.ndarray], other: Mapping[str, np.ndarray]) -> bool:
    """Whether all that both measure is a factor apart, to the last digits; one quantity alone tells nothing."""
    both = [(one[quantity], other[quantity]) for quantity in one if quantity in other]
    return len(both) > 1 and all(
        exact_factor(values - np.nanmean(values), of - np.nanmean(of)) is not None for of, values in both
    )


def _without_tool(columns: Sequence[JointColumn], numbers: Mapping[str, np.ndarray]) -> Sequence[JointColumn]:
    """The columns without those of a robot's tool beside several joints; beside one, without those of several numbers.

    What a tool does is no joint's; at the end of a single shaft a torque of a flange may be the load's.
    """
    rest = [column for column in columns if not has_word(column.read.words, TOOL)]
    joints = _Parts(rest, numbers, _by_number(rest)).joints
    joints = joints if len(joints) > 1 else _Parts(rest, numbers, _by_words(rest)).joints or joints
    of_tool = [column for column in columns if column not in rest]
    components = len({*_by_number(of_tool).values()} - {()}) > 1
    return rest if len(joints) > 1 or (joints and components) else columns


def _changes(values: np.ndarray) -> bool:
    """Whether values (n,) change at all; missing ones do not count."""
    known = values[np.isfinite(values)]
    return len(known) > 0 and float(np.ptp(known)) > 0.0


def _by_number(columns: Sequence[JointColumn]) -> dict[str, Part]:
    """The numbers in each column's name, including one in brackets."""
    words = {column.read.name: (*without_type(column.read.words), column.read.foreign) for column in columns}
    return {name: tuple(word for word in own if word.isdigit()) for name, own in words.items()}


def _by_words(columns: Sequence[JointColumn]) -> dict[str, Part]:
    """What the words of each column's name tell of its joint; ``l`` is the left and no load where there is an ``r``."""
    beside_right = {"l", "r"} <= {word for column in columns for word in column.read.words}
    return {column.read.name: part_of(column.read, column.quantity, load=not beside_right) for column in columns}


def _is_of_others(part: Part, own: Part, others: Sequence[Part]) -> bool:
    """Whether a column's name tells another joint, and that more closely than the chosen one."""
    also = len(own) if {*own} <= {*part} else 0
    return any({*other} <= {*part} and len(other) >= also for other in others)


def _is_elsewhere(column: JointColumn, part: Part, own: Part) -> bool:
    """Whether a column drives or moves what is no joint, such as a foot or the whole robot."""
    if column.quantity not in (*_DRIVES, *_MOVES):
        return False
    return not ({*part} <= {*own} or {*own} <= {*part})


def _are_one_train(motions: Sequence[HeaderWords], numbers: Mapping[str, np.ndarray], by_number: bool) -> bool:
    """Whether motions told apart ``by_number``, or else by words, are those of motor and output of one drive train.

    Shafts of a train are seldom named by words that tell no side, and joints of a robot often go almost in step: then
    all must go together but for next to nothing, and not equally far, as the joints of two legs do.
    """
    pairs = [(one, other) for place, one in enumerate(motions) for other in motions[place + 1 :]]
    if by_number:
        return any(_apart(one, other, numbers) < SMALL for one, other in pairs)
    return all(
        _apart(one, other, numbers) < NEGLIGIBLE
        and abs(travel(one, numbers) - travel(other, numbers)) > SMALL * travel(one, numbers)
        for one, other in pairs
    )


def travel(read: HeaderWords, numbers: Mapping[str, np.ndarray]) -> float:
    """The range of a position, in SI units if its name has a unit."""
    known = {unit: size for motion in MOTIONS for unit, size in units_of("motor_position", motion).items()}
    values = numbers[read.name]
    return float(np.ptp(values[np.isfinite(values)])) * known.get(read.unit or "", 1.0)


def _apart(one: HeaderWords, other: HeaderWords, numbers: Mapping[str, np.ndarray]) -> float:
    """The share of one motion that is not that of the other; little alone, since two joints may move in step."""
    return math.sqrt(1.0 - likeness(numbers[one.name], numbers[other.name]) ** 2)


def likeness(one: np.ndarray, other: np.ndarray) -> float:
    """Absolute correlation of two motions (n,): 1 if they always go the same way, or always against each other."""
    both = np.isfinite(one) & np.isfinite(other)
    ways = [values[both] - values[both].mean() for values in (one, other)]
    size = math.sqrt(float(ways[0] @ ways[0]) * float(ways[1] @ ways[1]))
    return min(1.0, abs(float(ways[0] @ ways[1])) / size) if size > 0.0 else 0.0

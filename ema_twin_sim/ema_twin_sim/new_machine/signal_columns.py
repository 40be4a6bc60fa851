"""Which column each signal is taken from: the words distinguish measurement and setpoint, motor and output."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from ema_bench_replay.traces.header_words import COUNTS, HeaderWords

from ..criteria import SMALL
from ..measured.exact_factor import exact_factor
from .column_quantity import has_word, word_quantity
from .column_words import (
    ACCELERATION_UNIT,
    ACTUAL,
    COMPUTED,
    DIRECT_OR_PHASE,
    ESTIMATED,
    FEEDFORWARD,
    FILTERED,
    FLOW_UNIT,
    INERTIAL,
    MOTOR,
    MOVED,
    NO_SIGNAL,
    NUMBER_OF_SOMETHING,
    NUMBERED,
    OUTPUT,
    POWER_UNIT,
    SETPOINT,
    SHARE,
    SUPPLY,
    SYMBOLS,
    TRANSDUCER,
)
from .joints import likeness, travel
from .never_changing import never_changes, zero_all_along
from .part_names import is_told
from .position_beside_speed import going_with_speed


@dataclass(frozen=True)
class Column:
    """A column that may be a signal."""

    read: HeaderWords
    quantity: str
    setpoint: bool
    actual: bool
    shaft: str  # motor, output, or empty if its name says none

    @property
    def name(self) -> str:
        """Its name in the header."""
        return self.read.name


def signal_column(read: HeaderWords) -> Column | None:
    """What a column may be; None if it is no signal."""
    is_feedforward = has_word(read.words, FEEDFORWARD) or ("feed", "forward") in pairwise(read.words)
    if has_word(read.words, NO_SIGNAL) or "ddot" in read.words or is_feedforward:
        return None
    if read.quantity is None and has_word(read.words[-1:], NUMBER_OF_SOMETHING):
        return None
    by_words = word_quantity(read.words)
    quantity = read.quantity or by_words
    if read.foreign and read.quantity is None and by_words is None:
        return None
    no_signals = POWER_UNIT if by_words == "torque" else f"{POWER_UNIT}|{ACCELERATION_UNIT}"  # a force may be in g
    if read.quantity is None and (re.fullmatch(no_signals, read.foreign) or read.words[-2:] == ("k", "w")):
        return None  # a letter beside it, as of an axis X or S, is no symbol of a position
    if quantity in (None, "time", "power") or re.fullmatch(FLOW_UNIT, read.foreign):
        return None
    words = _without_number_of_a_drive(read.words)
    axis = next((word for word in words[1:] if word in DIRECT_OR_PHASE), None) if len(words) == 2 else None
    if quantity in ("current", "voltage") and axis is not None:
        return None
    # of a position's symbol in the unit of a speed, as in qD [deg/s], the d is the dot
    desired = quantity in ("position", "speed") and "d" in words[1:] and by_words in (None, quantity)
    of_motor = has_word(words[1:], MOTOR) or has_word(words[:1], "motor|rotor")
    moved = quantity in ("position", "speed") and _is_of_what_is_moved(words)
    shaft = "output" if has_word(words, OUTPUT) or moved else "motor" if of_motor else ""
    return Column(read, quantity, desired or has_word(words, SETPOINT), has_word(words, ACTUAL), shaft)


def _without_number_of_a_drive(words: tuple[str, ...]) -> tuple[str, ...]:
    """A name's words without a number that only tells which drive it is, as in ``ODrive 2 Velocity``."""
    before = ("", *words)
    return tuple(word for k, word in enumerate(words) if not (word.isdigit() and re.search(NUMBERED, before[k])))


def _is_of_what_is_moved(words: Sequence[str]) -> bool:
    """Whether a column's words name what a motor moves, and no shaft."""
    return has_word(words, MOVED) and not (has_word(words, MOTOR) or has_word(words, OUTPUT))


def choose_signals(
    columns: Sequence[Column], numbers: Mapping[str, np.ndarray], time: HeaderWords | None
) -> tuple[dict[str, Column], tuple[str, ...]]:
    """The column of each signal that has one, and the positions that are left out since another goes with the speed."""
    taken: dict[str, Column] = {}

    def of(quantity: str, *, setpoint: bool = False) -> list[Column]:
        found = [c for c in columns if c.quantity == quantity and c.setpoint == setpoint and c not in taken.values()]
        found.sort(
            key=lambda c: (
                has_word(c.read.words, FILTERED),
                _is_of_another_sensor(c),
                _by_a_letter(c),
                c.shaft == "output",
                c.shaft != "motor",
                not c.actual,
            )
        )
        return sorted(found, key=lambda c: _is_idle(c, numbers))

    def take(signal: str, found: Sequence[Column]) -> None:
        if found:
            taken[signal] = found[0]

    take("temperature", of("temperature"))
    currents = of("current")
    told = of("torque")
    torques = sorted(
        told,
        key=lambda c: (
            _is_idle(c, numbers),
            c.shaft != "motor",
            _is_computed(c, told),
            not _of_a_current(c, currents, numbers),
        ),
    )
    may_drive = (c for c in told if c.shaft != "output" and not _measured_behind(c))
    drives = [*currents, *(c for c in may_drive if not has_word(c.read.words, FILTERED))]
    behind = [c for c in torques if c.shaft == "output" or (c.shaft == "" and drives and _measured_behind(c))]
    take("motor_torque", [c for c in torques if c not in behind])
    take("load_torque", behind)
    for signal, setpoint in (("current", False), ("current_setpoint", True)):
        take(signal, sorted(of("current", setpoint=setpoint), key=lambda c: not is_quadrature(c.read.words)))
    take("voltage", of("voltage"))
    take("speed", of("speed"))
    take("speed_setpoint", of("speed", setpoint=True))
    take("output_command", of("position", setpoint=True))
    positions = of("position")
    outputs = [c for c in positions if c.shaft == "output"]
    unsaid = [c for c in positions if c.shaft == ""]
    named = any(c.shaft == "motor" for c in positions)
    elsewhere = [] if named else _of_other_axes(unsaid, taken.get("speed"), time, numbers)
    if numbers:
        unsaid.sort(
            key=lambda c: (
                has_word(c.read.words, FILTERED),
                c in elsewhere,
                _is_of_another_sensor(c),
                _by_a_letter(c),
                -travel(c.read, numbers),
            )
        )
    by_words = [c for c in unsaid if word_quantity(c.read.words) == "position"]
    if by_words:  # what only counts may count anything
        unsaid.sort(key=lambda c: c.read.unit == COUNTS and c not in by_words)
    take("motor_position", [*(c for c in positions if c.shaft == "motor"), *unsaid])
    if (motor := taken.get("motor_position")) is not None:
        if motor in unsaid:  # a driver sets a pedal, which moves otherwise
            outputs = [c for c in outputs if not _is_of_what_is_moved(c.read.words) or _of_one_train(motor, c, numbers)]
        beside = [c for c in unsaid if c is not motor and not has_word(c.read.words, FILTERED)]
        outputs += [c for c in beside if _of_one_train(motor, c, numbers)]
    take("output_position", outputs)
    for signal, other in (("motor_position", "output_position"), ("motor_torque", "load_torque")):
        # a joint's angle without a motor's is taken for the motor's
        if signal not in taken and other in taken and not (signal == "motor_torque" and "current" in taken):
            taken[signal] = taken.pop(other)
    return taken, tuple(c.name for c in elsewhere if c not in taken.values())


def is_a_letter(read: HeaderWords) -> bool:
    """Whether a name is one letter without a unit, which may number something: one in full goes before it."""
    return read.unit is None and [len(word) for word in read.words if not word.isdigit()] == [1]


def _by_a_letter(column: Column) -> bool:
    """Whether one letter alone, among whatever other words, makes a column the signal, and nothing tells its shaft."""
    read = column.read
    letter = not any(len(word) > 1 for word in read.words if word in SYMBOLS.get(column.quantity, ()))
    return letter and column.shaft == "" and not is_told(read)


def _is_of_another_sensor(column: Column) -> bool:
    """Whether a name says an inertial sensor, which moves with the whole machine, or the drive's supply."""
    return has_word(column.read.words, f"{INERTIAL}|{SUPPLY}")


def _is_idle(column: Column, numbers: Mapping[str, np.ndarray]) -> bool:
    """Whether a position or a speed never changes, or a current or a torque is zero all along."""
    values = numbers.get(column.name)
    if column.quantity in ("position", "speed"):
        return never_changes(values)
    return column.quantity in ("current", "torque") and zero_all_along(values)


def _of_other_axes(
    positions: Sequence[Column], speed: Column | None, time: HeaderWords | None, numbers: Mapping[str, np.ndarray]
) -> list[Column]:
    """Those of several positions that go with the speed less than another does; none without a speed and a time."""
    judged = [c for c in positions if not has_word(c.read.words, FILTERED)]
    if len(judged) < 2 or speed is None or time is None or not numbers:
        return []
    going = going_with_speed({c.name: numbers[c.name] for c in judged}, numbers[speed.name], numbers[time.name])
    return [c for c in judged if c.name not in going]


def _of_one_train(one: Column, other: Column, numbers: Mapping[str, np.ndarray]) -> bool:
    """Whether two positions always move together, or always against each other; False if there are no numbers."""
    return bool(numbers) and likeness(numbers[one.name], numbers[other.name]) > 1.0 - SMALL


def other_torques(columns: Sequence[Column], taken: Mapping[str, Column]) -> list[Column]:
    """Measured torques beside the motor's that may be a load's, though no name says so.

    Without a current, the motor's torque must be named the motor's: of two others, nothing tells which one drives.
    """
    motors = taken.get("motor_torque")
    if motors is None or "load_torque" in taken or ("current" not in taken and motors.shaft != "motor"):
        return []
    unsaid = [c for c in columns if c.quantity == "torque" and not c.setpoint and c.shaft == ""]
    return [c for c in unsaid if c not in taken.values() and not has_word(c.read.words, FILTERED)]


def _of_a_current(torque: Column, currents: Sequence[Column], numbers: Mapping[str, np.ndarray]) -> bool:
    """Whether a torque is a factor times a current, to the last digits, so that the drive computed it."""
    if torque.name not in numbers:
        return False
    return any(exact_factor(numbers[torque.name], numbers[c.name]) is not None for c in currents if c.name in numbers)


def _is_computed(torque: Column, torques: Sequence[Column]) -> bool:
    """Whether a controller computed a torque. "cal" says so beside an estimate only: it may be a calibrated one."""
    estimated = any(has_word(c.read.words, ESTIMATED) for c in torques if c is not torque)
    return has_word(torque.read.words, f"{COMPUTED}|{SHARE}") or ("cal" in torque.read.words and estimated)


def _measured_behind(torque: Column) -> bool:
    """Whether a torque's name says that a transducer measured it, which a drive does not have."""
    return has_word(torque.read.words, TRANSDUCER)


def is_quadrature(words: Sequence[str]) -> bool:
    """Whether the words of a current's name are those of the quadrature axis, which makes a motor's torque."""
    return "q" in words or "iq" in words


def drive_command(columns: Sequence[Column], numbers: Mapping[str, np.ndarray]) -> Column | None:
    """A command of the torque, or else of the current, that changes: it serves if neither was measured."""
    commands = [c for c in columns if c.setpoint and not (c.name in numbers and np.ptp(numbers[c.name]) == 0.0)]
    torques = [c for c in commands if c.quantity == "torque"]
    currents = sorted((c for c in commands if c.quantity == "current"), key=lambda c: not is_quadrature(c.read.words))
    found = sorted(torques, key=lambda c: c.shaft == "output") or currents
    return min(found, key=lambda c: has_word(c.read.words, FILTERED), default=None)


def supply_current(names: Sequence[HeaderWords], numbers: Mapping[str, np.ndarray]) -> Column | None:
    """The supply's current, if it is never negative: how large the motor's is, without its sign."""
    for read in names:
        words = tuple(word for word in read.words if not re.search(SUPPLY, word))
        values = numbers.get(read.name)
        if len(words) == len(read.words) or values is None or not np.nanmin(values, initial=0.0) >= 0.0:
            continue
        column = signal_column(replace(read, words=words))
        if column is not None and column.quantity == "current" and not column.setpoint:
            return replace(column, read=read)
    return None

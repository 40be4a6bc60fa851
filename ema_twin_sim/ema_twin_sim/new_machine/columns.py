"""Guess what the columns of a text trace are from their names and the units in them.

If a name has a unit, that determines the quantity; otherwise the words do. The words also distinguish a setpoint from a
measurement, and the motor's shaft from the output's. Each signal is taken once, and each column too.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import AT_EITHER_SHAFT, MAY_BE_MAGNITUDES
from ema_bench_replay.traces.header_words import COUNTS, HeaderWords, header_words, in_other_letters
from ema_bench_replay.traces.import_map import TIME_UNITS
from ema_bench_replay.units import units_of

from ..criteria import SMALL
from .clock import is_uneven
from .column_words import (
    ACCELERATION_UNIT,
    ACTUAL,
    DIRECT_OR_PHASE,
    ENCODER,
    FILTERED,
    MOTOR,
    MOTOR_ITSELF,
    NO_SIGNAL,
    OUTPUT,
    POWER_UNIT,
    SETPOINT,
    SLIDES,
    STEMS,
    SUPPLY,
    SYMBOLS,
    TIME_IN_OTHER_LETTERS,
    TIME_WORDS,
    TRANSDUCER,
)
from .joints import ONE_JOINT, Joint, Numbered, likeness, one_joint, travel
from .position_beside_speed import going_with_speed


@dataclass(frozen=True)
class Guess:
    """One column that is taken for a signal; ``unit`` is None if its name has none that the signal can have."""

    signal: str
    column: str
    unit: str | None
    of_output: bool = False  # whether its name says that it is given at the output's shaft
    counts: float | None = None  # per turn, if it is a counter; None if they are unknown
    doubt: str = ""  # what to check, if the unit was not in the name
    of_motor: bool = False  # whether its name says that it is given at the motor's shaft
    shaft_doubt: str = ""  # what to check, if the shaft was not in the name
    turned_round: bool = False  # whether its sign is reversed
    magnitude: bool = False  # whether it has no sign
    command: bool = False  # whether it is a command in place of a measurement

    @property
    def shaft(self) -> str:
        """The shaft at which it is given according to its name, motor or output."""
        return "output" if self.of_output and self.signal in AT_EITHER_SHAFT else "motor"


@dataclass(frozen=True)
class Guesses:
    """What the columns of a trace seem to be."""

    time: Guess | None
    signals: tuple[Guess, ...]
    left: tuple[str, ...]  # columns that are not used
    motion: str  # rotary, or linear if a position is in metres
    of_points: bool = False  # whether each row is an operating point, not a sample of a motion
    points_doubt: str = ""  # why it is taken for one, if nobody said so
    joint: Joint = ONE_JOINT  # whose columns they are, if a trace holds those of several joints
    other_motion: tuple[str, ...] = ()  # columns not used since their units are those of the other kind of motion
    other_axes: tuple[str, ...] = ()  # positions not used since another goes with the speed more

    @property
    def drives(self) -> bool:
        """Whether the current or the motor's torque is among them, with its sign."""
        return any(guess.signal in MAY_BE_MAGNITUDES and not guess.magnitude for guess in self.signals)

    def without(self, columns: Sequence[str]) -> Guesses:
        """The same without using these columns."""
        kept = tuple(guess for guess in self.signals if guess.column not in columns)
        return replace(self, signals=kept, left=(*self.left, *columns))

    def as_magnitudes(self, signals: Collection[str]) -> Guesses:
        """The same with these signals read as magnitudes without sign."""
        read = tuple(replace(guess, magnitude=True) if guess.signal in signals else guess for guess in self.signals)
        return replace(self, signals=read)

    @property
    def both_encoders(self) -> bool:
        """Whether the positions of motor and output are among them."""
        return {"motor_position", "output_position"} <= {guess.signal for guess in self.signals}


@dataclass(frozen=True)
class _Column:
    """A column that may be a signal."""

    read: HeaderWords
    quantity: str
    setpoint: bool
    actual: bool
    shaft: str  # motor, output, or empty if its name says none

    @property
    def name(self) -> str:
        return self.read.name


def guess_columns(
    header: Sequence[str],
    no_numbers: frozenset[str] = frozenset(),
    numbers: Mapping[str, np.ndarray] | None = None,
    joint: str = "",
) -> Guesses:
    """Guess what each column of a header is.

    Columns in ``no_numbers`` are not used. ``numbers`` are the columns' values, (n,) each: of several positions whose
    names give no shaft, those that go with the speed most are the machine's, and of two that move together the one that
    goes farther is the motor's. If there are columns of several joints, those of ``joint`` are taken, else those of the
    joint that goes farthest. Raises InputError if the time has no numbers.
    """
    names = [header_words(name) for name in header]
    linear = _is_linear(names)
    names = [_settled(read, linear) for read in names]
    time = _time_column(names, numbers or {})
    if time is not None and time.name in no_numbers:
        raise InputError(
            f"header: column {time.name!r} holds no numbers; export the time in s or ms, counted from the start"
        )
    usable = [read for read in names if read is not time and read.name not in no_numbers]
    whole = {name: values for name, values in (numbers or {}).items() if name not in no_numbers}
    of_joint, usable = one_joint([_numbered(read) for read in usable], whole, joint)
    other_motion = tuple(
        read.name for read in usable if read.linear not in (None, linear) and _column(read) is not None
    )
    columns = [column for column in map(_column, usable) if column is not None and column.name not in other_motion]
    taken, other_axes = _signals(columns, numbers or {}, time)
    command = None if {"current", "motor_torque"} & taken.keys() else _command(columns, numbers or {})
    if command is not None:
        signal = "motor_torque" if command.quantity == "torque" else "current"
        besides = {name: column for name, column in taken.items() if column is not command}
        taken = {name: {**besides, signal: command}[name] for name in _ORDER if name in {*besides, signal}}
    supply = None if {"current", "motor_torque"} & taken.keys() else _supply_current(usable, numbers or {})
    if supply is not None:
        taken = {name: {**taken, "current": supply}[name] for name in _ORDER if name in {*taken, "current"}}
    motion = "linear" if linear else "rotary"
    signals = tuple(
        Guess(
            signal,
            column.name,
            _unit(column.read, signal, motion),
            column.shaft == "output" or (signal == "load_torque" and column.shaft == ""),
            of_motor=column.shaft == "motor",
            magnitude=column is supply,
            command=column is command,
        )
        for signal, column in taken.items()
    )
    used = {column.name for column in taken.values()}
    left = tuple(name for name in header if name not in used and (time is None or name != time.name))
    guesses = _timed(time, signals, left, motion)
    return replace(guesses, joint=of_joint, other_motion=other_motion, other_axes=other_axes)


def named_columns(named: Mapping[str, str]) -> Guesses:
    """Guesses from the columns that a person named, by signal (including ``time``), with the units in their names.

    Raises InputError if a name has a unit that its signal cannot have.
    """
    read = {signal: header_words(name) for signal, name in named.items()}
    linear = _is_linear([words for signal, words in read.items() if signal.endswith("position")])
    motion = "linear" if linear else "rotary"
    signals = []
    for signal, words in read.items():
        if signal == "time":
            continue
        unit = _unit(words, signal, motion)
        if unit is None and (words.foreign or (words.unit is not None and not words.in_doubt)):
            raise InputError(
                f"init: {words.name!r}: its unit is not one of the {signal.replace('_', ' ')} of a {motion} machine; "
                f"use one of {', '.join(units_of(signal, motion))}"
            )
        signals.append(Guess(signal, words.name, unit, bool(_has(words.words, OUTPUT))))
    return _timed(read.get("time"), tuple(signals), (), motion)


def _timed(time: HeaderWords | None, signals: tuple[Guess, ...], left: tuple[str, ...], motion: str) -> Guesses:
    """Guesses with a time column or, without one, with rows that are operating points."""
    if time is not None:
        return Guesses(_time(time), signals, left, motion)
    return Guesses(None, signals, left, motion, of_points=True, points_doubt="no time column was found")


def _has(words: Sequence[str], pattern: str) -> bool:
    return any(re.search(pattern, word) for word in words)


def _is_linear(names: Sequence[HeaderWords]) -> bool:
    """Whether the machine is linear, by the unambiguous units of positions, else of speeds, else of torques.

    A motor that turns decides for a rotary one.
    """
    sure = [read for read in names if not read.in_doubt and read.linear is not None]
    if any(not read.linear and read.quantity != "torque" and _has(read.words, MOTOR_ITSELF) for read in sure):
        return False
    for quantity in ("position", "speed", "torque"):
        if told := [read.linear for read in sure if read.quantity == quantity]:
            return any(told)
    doubted = [read for read in names if read.in_doubt and read.unit == "m"]
    return len(doubted) == 1 and _has(doubted[0].words, SLIDES)  # if there are several, m is a subscript for the motor


def _settled(read: HeaderWords, linear: bool) -> HeaderWords:
    """The name after deciding whether an ambiguous letter is a unit or a subscript."""
    if not read.in_doubt:
        return read
    fits = read.quantity == _word_quantity(read.words) and (read.linear is None or read.linear == linear)
    return replace(read, in_doubt=False) if fits else read.as_subscript()


def _word_quantity(words: Sequence[str]) -> str | None:
    """The quantity that the words give; a position with a dot is a speed."""
    found = next(
        (quantity for quantity, pattern in STEMS.items() if _has(words, pattern)),
        next(
            (q for word in words for q, known in SYMBOLS.items() if word in known and not _numbers(word, words)), None
        ),
    )
    return "speed" if found == "position" and "dot" in words else found


def _numbers(letter: str, words: Sequence[str]) -> bool:
    """Whether a letter only numbers what the words name, as in ``m1foo``: of a motor, a sensor, an axis."""
    if len(letter) > 1 or len(words) < 3 or words[0] != letter or not words[1].isdigit():
        return False
    known = f"{SETPOINT}|{ACTUAL}|{OUTPUT}|{MOTOR}|{FILTERED}|^(dot|raw|\\d+)$"
    return not all(re.search(known, word) for word in words[2:])


def contradicted_quantity(name: str) -> str:
    """The quantity that a column's words give if its unit is clearly of another one; empty if both agree.

    Not a contradiction: a torque in amperes, and a speed of an encoder. Symbols of one letter are not considered.
    """
    read = header_words(name)
    said = {quantity for quantity, pattern in STEMS.items() if _has(read.words, pattern)}
    if read.quantity is None or read.in_doubt or not said or read.quantity in said:
        return ""
    if read.quantity == "current" and "torque" in said:
        return ""
    if read.quantity == "speed" and _has(read.words, ENCODER + r"|dot"):
        return ""
    return next(quantity for quantity in STEMS if quantity in said)


def _time_column(names: Sequence[HeaderWords], numbers: Mapping[str, np.ndarray]) -> HeaderWords | None:
    """The time column: by its name, or by a unit of time; of several, the first that rises.

    One with both is the clock even if it does not rise: reading it tells what is wrong with it. One with the unit alone
    must go in even steps, as a clock does: the slip of a motor may be given in s as well.
    """
    called = [read for read in names if _is_time(read)]
    others = [read for read in names if read.quantity == "time" and read not in called]
    if called and not numbers:
        return called[0]
    rising = [read for read in (*called, *others) if read.name in numbers and (np.diff(numbers[read.name]) > 0.0).all()]
    rising = [read for read in rising if read in called or not is_uneven(numbers[read.name])]
    clocks = [read for read in called if read.quantity == "time"]
    return next(iter((*(read for read in rising if read in called), *clocks, *rising, *called)), None)


def _is_time(read: HeaderWords) -> bool:
    if read.quantity not in ("time", None) or read.foreign:
        return False
    if not read.words and in_other_letters(read.name):
        return re.search(TIME_IN_OTHER_LETTERS, read.name.lower()) is not None
    known = all(re.search(TIME_WORDS, word) for word in read.words) and bool(read.words or read.quantity)
    if read.quantity == "time":
        # the x axis of a plot is time if its unit is one of time
        return known or _word_quantity(read.words) == "time" or read.words == ("x",)
    if read.words == ("x", "value"):  # LabVIEW's name for the time of a measurement
        return True
    return known or (_has(read.words, r"time|zeit|stamp") and not _has(read.words, NO_SIGNAL))


def _column(read: HeaderWords) -> _Column | None:
    """What a column may be; None if it is no signal."""
    if _has(read.words, NO_SIGNAL) or "ddot" in read.words:
        return None
    by_words = _word_quantity(read.words)
    quantity = read.quantity or by_words
    if read.foreign and read.quantity is None and by_words is None:
        return None
    no_signals = POWER_UNIT if by_words == "torque" else f"{POWER_UNIT}|{ACCELERATION_UNIT}"  # a force may be in g
    if read.quantity is None and (re.fullmatch(no_signals, read.foreign) or read.words[-2:] == ("k", "w")):
        return None  # a letter beside it, as of an axis X or S, is no symbol of a position
    if quantity in (None, "time", "power"):
        return None
    words = read.words
    axis = next((word for word in words[1:] if word in DIRECT_OR_PHASE), None) if len(words) == 2 else None
    if quantity in ("current", "voltage") and axis is not None:
        return None
    desired = quantity in ("position", "speed") and "d" in words[1:]
    shaft = (
        "output" if _has(words, OUTPUT) else "motor" if _has(words[1:], MOTOR) or _has(words[:1], "motor|rotor") else ""
    )
    return _Column(read, quantity, desired or _has(words, SETPOINT), _has(words, ACTUAL), shaft)


def _command(columns: Sequence[_Column], numbers: Mapping[str, np.ndarray]) -> _Column | None:
    """A command of the torque, or else of the current, that changes: it serves if neither was measured."""
    commands = [c for c in columns if c.setpoint and not (c.name in numbers and np.ptp(numbers[c.name]) == 0.0)]
    torques = [c for c in commands if c.quantity == "torque"]
    currents = sorted((c for c in commands if c.quantity == "current"), key=lambda c: not is_quadrature(c.read.words))
    found = sorted(torques, key=lambda c: c.shaft == "output") or currents
    return min(found, key=lambda c: _has(c.read.words, FILTERED), default=None)


def _supply_current(names: Sequence[HeaderWords], numbers: Mapping[str, np.ndarray]) -> _Column | None:
    """The supply's current, if it is never negative: how large the motor's is, without its sign."""
    for read in names:
        words = tuple(word for word in read.words if not re.search(SUPPLY, word))
        values = numbers.get(read.name)
        if len(words) == len(read.words) or values is None or not np.nanmin(values, initial=0.0) >= 0.0:
            continue
        column = _column(replace(read, words=words))
        if column is not None and column.quantity == "current" and not column.setpoint:
            return replace(column, read=read)
    return None


def _numbered(read: HeaderWords) -> Numbered:
    """A column with its quantity, for the search for joints that are numbered in the names."""
    column = _column(read)
    return Numbered(read, None, False) if column is None else Numbered(read, column.quantity, column.setpoint)


def _signals(
    columns: Sequence[_Column], numbers: Mapping[str, np.ndarray], time: HeaderWords | None
) -> tuple[dict[str, _Column], tuple[str, ...]]:
    """The column of each signal that has one, and the positions that are left out since another goes with the speed."""
    taken: dict[str, _Column] = {}

    def of(quantity: str, *, setpoint: bool = False) -> list[_Column]:
        found = [c for c in columns if c.quantity == quantity and c.setpoint == setpoint and c not in taken.values()]
        return sorted(found, key=lambda c: (_has(c.read.words, FILTERED), c.shaft == "output", not c.actual))

    def take(signal: str, found: Sequence[_Column]) -> None:
        if found:
            taken[signal] = found[0]

    take("temperature", of("temperature"))
    torques, currents = of("torque"), of("current")
    behind = [c for c in torques if c.shaft == "output" or (c.shaft == "" and currents and _measured_behind(c))]
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
        unsaid.sort(key=lambda c: (_has(c.read.words, FILTERED), c in elsewhere, -travel(c.read, numbers)))
    take("motor_position", [*(c for c in positions if c.shaft == "motor"), *unsaid])
    if (motor := taken.get("motor_position")) is not None:
        beside = [c for c in unsaid if c is not motor and not _has(c.read.words, FILTERED)]
        outputs += [c for c in beside if _of_one_train(motor, c, numbers)]
    take("output_position", outputs)
    for signal, other in (("motor_position", "output_position"), ("motor_torque", "load_torque")):
        # a joint's angle without a motor's is taken for the motor's
        if signal not in taken and other in taken and not (signal == "motor_torque" and "current" in taken):
            taken[signal] = taken.pop(other)
    left_out = tuple(c.name for c in elsewhere if c not in taken.values())
    return {name: taken[name] for name in _ORDER if name in taken}, left_out


def _of_other_axes(
    positions: Sequence[_Column], speed: _Column | None, time: HeaderWords | None, numbers: Mapping[str, np.ndarray]
) -> list[_Column]:
    """Those of several positions that go with the speed less than another does; none without a speed and a time."""
    judged = [c for c in positions if not _has(c.read.words, FILTERED)]
    if len(judged) < 2 or speed is None or time is None or not numbers:
        return []
    going = going_with_speed({c.name: numbers[c.name] for c in judged}, numbers[speed.name], numbers[time.name])
    return [c for c in judged if c.name not in going]


_ORDER = (
    "temperature",
    "load_torque",
    "current_setpoint",
    "current",
    "speed_setpoint",
    "output_command",
    "output_position",
    "motor_torque",
    "speed",
    "motor_position",
    "voltage",
)
"""Signals in the order in which a map lists them."""


def _of_one_train(one: _Column, other: _Column, numbers: Mapping[str, np.ndarray]) -> bool:
    """Whether two positions always move together, or always against each other; False if there are no numbers."""
    return bool(numbers) and likeness(numbers[one.name], numbers[other.name]) > 1.0 - SMALL


def _measured_behind(torque: _Column) -> bool:
    """Whether a torque's name says that a transducer measured it, which a drive does not have."""
    return _has(torque.read.words, TRANSDUCER)


def is_quadrature(words: Sequence[str]) -> bool:
    """Whether the words of a current's name are those of the quadrature axis, which makes a motor's torque."""
    return "q" in words or "iq" in words


def _time(read: HeaderWords) -> Guess:
    return Guess("time", read.name, read.unit if read.unit in TIME_UNITS else None)


def _unit(read: HeaderWords, signal: str, motion: str) -> str | None:
    """The unit in the name, if the signal can have it."""
    if read.unit == COUNTS:
        return COUNTS if signal in ("motor_position", "output_position") and motion == "rotary" else None
    return read.unit if read.unit in units_of(signal, motion) else None

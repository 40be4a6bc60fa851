"""Guess what the columns of a text trace are from their names and the units in them.

If a name has a unit, that determines the quantity; otherwise the words do. The words also distinguish a setpoint from a
measurement, and the motor's shaft from the output's. Each signal is taken once, and each column too.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import AT_EITHER_SHAFT, MAY_BE_MAGNITUDES
from ema_bench_replay.traces.header_words import COUNTS, HeaderWords, header_words, is_unit
from ema_bench_replay.traces.import_map import TIME_UNITS
from ema_bench_replay.units import units_of

from .clock_counters import clock_counters
from .column_quantity import contradicted_quantity, has_word, word_quantity
from .column_words import ENCODER, MOTOR_ITSELF, OUTPUT, SLIDES
from .control_errors import control_errors
from .joints import ONE_JOINT, Joint, JointColumn, one_joint
from .never_changing import never_changes
from .part_names import without_lone_letters
from .phase_angles import phase_angles
from .power_analyser import analysers_columns
from .repeated_columns import repeated_columns
from .row_counters import row_counters
from .shared_words import without_shared_quantities
from .sign_bits import sign_bits
from .signal_columns import choose_signals, drive_command, other_torques, signal_column, supply_current
from .time_column import is_assumed, time_column

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
    origin_doubt: str = ""  # what to check, if it may be of another part of the machine than the signals beside it
    turned_round: bool = False  # whether its sign is reversed
    factor: float = 1.0  # how many of its units one in the column is
    magnitude: bool = False  # whether it has no sign
    command: bool = False  # whether it is a command in place of a measurement
    wraps_after: float | None = None  # after how many of its units it starts again; None: after one turn, or never

    @property
    def shaft(self) -> str:
        """The shaft at which it is given according to its name, motor or output."""
        return "output" if self.of_output and self.signal in AT_EITHER_SHAFT else "motor"

    @property
    def foreign_unit(self) -> str:
        """The unit in its name that its signal cannot have; empty if there is none. A number in brackets is no unit."""
        foreign = header_words(self.column).foreign
        return "" if self.unit is not None or foreign.isdigit() else foreign


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
    other_torques: tuple[Guess, ...] = ()  # torques beside the motor's, as the loads that they may be
    row_counters: tuple[str, ...] = ()  # columns not used since they only number the rows
    clock_counters: tuple[str, ...] = ()  # columns not used since they count time
    sign_bits: Mapping[str, int] = field(default_factory=dict)  # columns not used since this bit is a sign
    phase_angles: tuple[str, ...] = ()  # columns not used since they are angles between voltage and current
    electrical: tuple[str, ...] = ()  # columns not used since a power analyser's voltages and powers are named so
    lost_commands: Mapping[str, str] = field(default_factory=dict)  # commanded positions not used, and why
    control_errors: Mapping[str, str] = field(default_factory=dict)  # not used: that of these, in words
    repeats: Mapping[str, str] = field(default_factory=dict)  # not used: copies of these, in words

    @property
    def by_signal(self) -> dict[str, Guess]:
        """The columns that are taken, by what each is taken for."""
        return {guess.signal: guess for guess in self.signals}

    def named(self, *signals: str) -> str:
        """The names of the columns that are taken for these ``signals``, as a list in a sentence."""
        return ", ".join(guess.column for guess in self.signals if guess.signal in signals)

    @property
    def drives(self) -> bool:
        """Whether the current or the motor's torque is among them, with its sign."""
        return any(guess.signal in MAY_BE_MAGNITUDES and not guess.magnitude for guess in self.signals)

    def without(self, columns: Sequence[str]) -> Guesses:
        """The same without using these columns."""
        kept = tuple(guess for guess in self.signals if guess.column not in columns)
        return replace(self, signals=kept, left=(*self.left, *columns))

    def timed_in_seconds(self, columns: Collection[str]) -> Guesses:
        """The same with a time in s, whatever its name says, if these columns of dates or times of day hold it."""
        if self.time is None or self.time.column not in columns:
            return self
        return replace(self, time=replace(self.time, unit="s"))

    def changed(self, signals: Collection[str], **fields: Any) -> Guesses:
        """The same with other ``fields`` of the columns that are taken for these ``signals``."""
        read = tuple(replace(guess, **fields) if guess.signal in signals else guess for guess in self.signals)
        return replace(self, signals=read)

    def with_load(self, load: Guess) -> Guesses:
        """The same with a column taken for the load, whatever it was taken for."""
        signals = (load, *(each for each in self.signals if each.column != load.column))
        return replace(
            self,
            signals=tuple(sorted(signals, key=lambda each: _ORDER.index(each.signal))),
            left=tuple(name for name in self.left if name != load.column),
            other_torques=(),
        )

    @property
    def both_encoders(self) -> bool:
        """Whether the positions of motor and output are among them."""
        return {"motor_position", "output_position"} <= self.by_signal.keys()


def guess_columns(
    header: Sequence[str],
    no_numbers: frozenset[str] = frozenset(),
    numbers: Mapping[str, np.ndarray] | None = None,
    joint: str = "",
    *,
    slides: bool = False,
) -> Guesses:
    """Guess what each column of a header is.

    Columns in ``no_numbers`` are not used. ``numbers`` are the columns' values, (n,) each: of several positions whose
    names give no shaft, those that go with the speed most are the machine's, and of two that move together the one that
    goes farther is the motor's. If there are columns of several joints, those of ``joint`` are taken, else those of the
    joint that goes farthest. If the machine ``slides`` by a known way per turn of its motor, it is linear wherever a
    unit of length is told, and columns of its motor's turns are used too. Raises InputError if the time has no numbers.
    """
    numbers = numbers or {}
    header = [*dict.fromkeys(header)]  # a map finds by name the first of several that have one
    names = without_shared_quantities([header_words(name) for name in header])
    telling = _telling(names, numbers)
    sure = (read for read in telling if not read.in_doubt and read.quantity in ("position", "speed"))
    linear = _is_linear(telling) or (slides and any(read.linear for read in sure))
    names = [_settled(read, linear, names) for read in names]
    time = time_column(names, numbers)
    assumed = time is not None and is_assumed(time, names, numbers)
    if time is not None and time.name in no_numbers:
        raise InputError(
            f"header: column {time.name!r} holds no numbers; export the time in s or ms, counted from the start"
        )
    names = [*without_lone_letters([read for read in names if read is not time])]
    counters = row_counters(names, numbers, time)
    clocks = clock_counters([read for read in names if read.name not in {*no_numbers, *counters}], numbers, time)
    analysed = analysers_columns([read for read in names if read.name not in no_numbers], numbers)
    electrical = tuple(name for family in analysed.values() for name in family)
    angles, signs = phase_angles(names, analysed), sign_bits(names, numbers)
    unusable = {*no_numbers, *counters, *clocks, *angles, *signs, *electrical}
    usable = [read for read in names if read.name not in unusable]
    whole = {name: values for name, values in numbers.items() if name not in no_numbers}
    of_joint, usable = one_joint([_joint_column(read) for read in usable], whole, joint)
    repeats = repeated_columns(usable, numbers)
    usable = [read for read in usable if read.name not in repeats]
    errors = control_errors(usable, numbers)
    usable = [read for read in usable if read.name not in errors]
    other_motion = tuple(
        read.name
        for read in usable
        if (read.unit == COUNTS if slides and linear else read.linear not in (None, linear))
        and signal_column(read) is not None
    )
    columns = [column for column in map(signal_column, usable) if column and column.name not in other_motion]
    taken, other_axes = choose_signals(columns, numbers, time)
    unmeasured = not {"current", "motor_torque"} & taken.keys()
    command = drive_command(columns, numbers) if unmeasured else None
    supply = supply_current(usable, numbers) if unmeasured and command is None else None
    if command is not None:
        taken = {signal: column for signal, column in taken.items() if column is not command}
        taken["motor_torque" if command.quantity == "torque" else "current"] = command
    elif supply is not None:
        taken["current"] = supply
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
        for signal, column in sorted(taken.items(), key=lambda item: _ORDER.index(item[0]))
    )
    loads = tuple(
        Guess("load_torque", column.name, _unit(column.read, "load_torque", motion), of_output=True)
        for column in other_torques(columns, taken)
        if column.name in whole
    )
    used = {column.name for column in taken.values()}
    left = tuple(name for name in header if name not in used and (time is None or name != time.name))
    guesses = _timed(time, signals, left, motion)
    if guesses.time is not None and assumed:
        doubt = "taken for the time by its unit alone, though its steps are uneven"
        guesses = replace(guesses, time=replace(guesses.time, doubt=doubt))
    return replace(
        guesses,
        joint=of_joint,
        other_motion=other_motion,
        other_axes=other_axes,
        other_torques=loads,
        row_counters=counters,
        clock_counters=clocks,
        phase_angles=angles,
        electrical=electrical,
        control_errors=errors,
        repeats=repeats,
        sign_bits=signs,
    )


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
        signals.append(Guess(signal, words.name, unit, has_word(words.words, OUTPUT)))
    return _timed(read.get("time"), tuple(signals), (), motion)


def _timed(time: HeaderWords | None, signals: tuple[Guess, ...], left: tuple[str, ...], motion: str) -> Guesses:
    """Guesses with a time column or, without one, with rows that are operating points."""
    if time is not None:
        return Guesses(_time(time), signals, left, motion)
    return Guesses(None, signals, left, motion, of_points=True, points_doubt="no time column was found")


def _telling(names: Sequence[HeaderWords], numbers: Mapping[str, np.ndarray]) -> list[HeaderWords]:
    """The names whose units tell the kind of motion: not where the words contradict them, nor where nothing changes.

    Unless nothing changes that has such a unit.
    """
    sure = [name for name in names if not contradicted_quantity(name.name)]
    moving = [name for name in sure if not never_changes(numbers.get(name.name))]
    told = any(name.linear is not None and not name.in_doubt and name.quantity != "torque" for name in moving)
    return moving if told else sure


def _is_linear(names: Sequence[HeaderWords]) -> bool:
    """Whether the machine is linear, by the unambiguous units of positions, else of speeds, else of torques.

    A motor that turns decides for a rotary one.
    """
    sure = [read for read in names if not read.in_doubt and read.linear is not None]
    if any(not read.linear and read.quantity != "torque" and has_word(read.words, MOTOR_ITSELF) for read in sure):
        return False
    for quantity in ("position", "speed", "torque"):
        if told := [read.linear for read in sure if read.quantity == quantity]:
            return any(told)
    doubted = [read for read in names if read.in_doubt and read.unit == "m"]
    return len(doubted) == 1 and has_word(doubted[0].words, SLIDES)  # several: m is a subscript for the motor


def _settled(read: HeaderWords, linear: bool, names: Sequence[HeaderWords]) -> HeaderWords:
    """The name, one of the header's, after deciding whether an ambiguous letter is a unit or a subscript."""
    if not read.in_doubt:
        return read
    fits = read.quantity == word_quantity(read.words) and (read.linear is None or read.linear == linear)
    return replace(read, in_doubt=False) if fits or _is_written_as_a_unit(read, names) else read.as_subscript()


def _is_written_as_a_unit(read: HeaderWords, names: Sequence[HeaderWords]) -> bool:
    """Whether a capital letter ends one name alone, beside names that end in units: ``encoder_V`` beside ``time_s``.

    A letter of a part ends the names of several columns, and a subscript is small. Where the words tell a quantity that
    is not the unit's, the letter is that of a part as well, as in ``speed_A``; what an encoder gives may be a voltage.
    """
    if word_quantity(read.words) not in (None, read.quantity) and not has_word(read.words, ENCODER):
        return False
    tails = {other.name: other.name.strip().rpartition("_")[2] for other in names if "_" in other.name}
    letter = tails.pop(read.name, "")
    beside = any(is_unit(tail) and (len(tail) > 1 or tail == "s") for tail in tails.values())
    return letter in ("A", "V") and letter not in tails.values() and beside


def _time(read: HeaderWords) -> Guess:
    return Guess("time", read.name, read.unit if read.unit in TIME_UNITS else None)


def _unit(read: HeaderWords, signal: str, motion: str) -> str | None:
    """The unit in the name, if the signal can have it."""
    if read.unit == COUNTS:
        return COUNTS if signal in ("motor_position", "output_position") and motion == "rotary" else None
    return read.unit if read.unit in units_of(signal, motion) else None


def _joint_column(read: HeaderWords) -> JointColumn:
    """A column with its quantity, for the search for joints that the names distinguish."""
    column = signal_column(read)
    return JointColumn(read, None, False) if column is None else JointColumn(read, column.quantity, column.setpoint)

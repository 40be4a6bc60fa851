"""Guessing what the columns of a text trace are, from their names and the units in them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import AT_EITHER_SHAFT
from ema_bench_replay.traces.import_map import TIME_UNITS
from ema_bench_replay.units import units_of

_SET = r"(\bset|\bref|\bcmd|command|desired|target|soll|demand|goal)"
_NO_SIGNAL = re.compile(r"error|fehler|deviation|abweichung|limit|\bdc\b|\bmax|\bmin\b", re.IGNORECASE)
_TORQUE = r"torque|force|moment|kraft"
_SPEED = r"speed|velocity|drehzahl|geschwindigkeit|omega"
_PLACE = r"position|angle|pos\b|lage|winkel|\bweg\b|twist|verdreh"
_OUTPUT = r"(output|load|joint|link|arm|slow|secondary|abtrieb)"

_SIGNALS: tuple[tuple[str, str], ...] = (
    ("temperature", r"\btemp\b|temperatur"),
    ("load_torque", rf"(?=.*({_TORQUE}))(?=.*{_OUTPUT}|.*(brake|dyno))"),
    ("current_setpoint", rf"(?=.*(current|strom|\bi ?q\b))(?=.*{_SET})"),
    ("current", r"current|strom|\bi ?q\b|^i$|^cur$"),
    ("speed_setpoint", rf"(?=.*({_SPEED}))(?=.*{_SET})"),
    ("output_command", rf"(?=.*({_PLACE}|^q\b))(?=.*{_SET})"),
    ("output_position", rf"(?=.*({_PLACE}|encoder))(?=.*{_OUTPUT})"),
    ("motor_torque", rf"^(?!.*{_SET}).*({_TORQUE})"),
    ("speed", rf"{_SPEED}|\brpm\b|^vel$|^n$"),
    ("motor_position", rf"{_PLACE}|encoder|\btheta\b|^q$|^x$"),
    ("voltage", r"voltage|spannung|\bu ?q\b"),
)
"""Signals in the order in which they are looked for, and what the name of their column has in it."""

_TIME = re.compile(r"\b(time|zeit|timestamp)\b|^t$|^t (s|ms|us)$", re.IGNORECASE)
_AXIS = re.compile(r"x", re.IGNORECASE)  # of a drawing: time, where its unit is one of time
_UNIT = re.compile(r"[\[(]\s*([^\])]+?)\s*[\])]\s*$")
_SPELLINGS = {
    "nm": "N m", "n*m": "N m", "n.m": "N m", "mnm": "mN m", "knm": "kN m", "1/min": "rpm", "u/min": "rpm",
    "min-1": "rpm", "r/min": "rpm", "°": "deg", "degree": "deg", "degrees": "deg", "°/s": "deg/s", "grad": "deg",
    "radians": "rad", "°c": "degC", "c": "degC", "sec": "s", "seconds": "s", "msec": "ms", "turn": "rev",
    "turns": "rev", "ampere": "A", "amps": "A", "volt": "V",
}  # fmt: skip


@dataclass(frozen=True)
class Guess:
    """One column that is taken for a signal; ``unit`` is None where its name tells none that the signal can have."""

    signal: str
    column: str
    unit: str | None

    @property
    def shaft(self) -> str:
        """The shaft that its name says it is told at, motor or output."""
        at_output = self.signal in AT_EITHER_SHAFT and re.search(_OUTPUT, _words(self.column), re.IGNORECASE)
        return "output" if at_output else "motor"


@dataclass(frozen=True)
class Guesses:
    """What the columns of a trace seem to be."""

    time: Guess | None
    signals: tuple[Guess, ...]
    left: tuple[str, ...]  # columns that nothing is made of
    motion: str  # rotary, or linear where a position is in metres

    @property
    def drives(self) -> bool:
        """Whether what drives the machine is among them."""
        return any(guess.signal in ("current", "motor_torque") for guess in self.signals)

    @property
    def both_encoders(self) -> bool:
        """Whether the positions of motor and output are among them."""
        return {"motor_position", "output_position"} <= {guess.signal for guess in self.signals}


def guess_columns(header: Sequence[str], no_numbers: frozenset[str] = frozenset()) -> Guesses:
    """What each column of a header is taken for; each signal is taken once, each column too.

    Nothing is made of the columns that hold ``no_numbers``. Raises InputError where the time is among them.
    """
    time = next((name for name in header if _is_time(name)), None)
    if time in no_numbers:
        raise InputError(
            f"header: column {time!r} holds no numbers; export the time in s or ms, counted from the start"
        )
    usable = [name for name in header if name != time and name not in no_numbers]
    free = [name for name in usable if not _NO_SIGNAL.search(_words(name))]
    taken: dict[str, str] = {}
    for signal, pattern in _SIGNALS:
        for name in free:
            if re.search(pattern, _words(name), re.IGNORECASE):
                taken[signal] = name
                free.remove(name)
                break
    _as_the_only_one(taken, "motor_position", "output_position")
    if "current" not in taken:
        _as_the_only_one(taken, "motor_torque", "load_torque")
    linear = any(
        _UNIT.search(name) and _unit(name, signal, "linear")
        for signal, name in taken.items()
        if signal.endswith("position")
    )
    motion = "linear" if linear else "rotary"
    signals = tuple(Guess(signal, name, _unit(name, signal, motion)) for signal, name in taken.items())
    left = tuple(name for name in header if name != time and name not in taken.values())
    return Guesses(None if time is None else _time(time), signals, left, motion)


def _as_the_only_one(taken: dict[str, str], signal: str, other: str) -> None:
    """The machine's own where there is but one: of a joint's angle alone, it is the motor's that the joint tells."""
    if signal not in taken and other in taken:
        taken[signal] = taken.pop(other)


def _is_time(name: str) -> bool:
    words = _words(name)
    return bool(_TIME.search(words) or (_AXIS.fullmatch(words) and _time_unit(name)))


def _words(name: str) -> str:
    """A column's name without its unit, its words apart: ``motorPosition_deg`` as ``motor Position deg``."""
    plain = _UNIT.sub("", name)
    return re.sub(r"(?<=[a-z])(?=[A-Z])|[_.:]+", " ", plain).strip()


def _units_in(name: str) -> list[str]:
    """What may be the unit in a name: in brackets, or its last words (``n_rad_s``, ``torque_N_m``, ``v_m_per_s``)."""
    found = _UNIT.search(name)
    if found:
        said = [found[1]]
    else:
        *before, last = [word for word in re.split(r"[\s_]+", name.strip()) if word != "per"]
        said = [*(f"{word}{between}{last}" for word in before[-1:] for between in "/ "), last]
    return [_SPELLINGS.get(text.lower(), text) for text in said]


def named_columns(named: Mapping[str, str]) -> Guesses:
    """The columns that a person named, by signal (``time`` among them), with the units in their names.

    Raises InputError where a name states a unit that its signal cannot have.
    """
    linear = any(_unit(name, signal, "linear") for signal, name in named.items() if signal.endswith("position"))
    motion = "linear" if linear else "rotary"
    signals = []
    for signal, name in named.items():
        if signal == "time":
            continue
        unit = _unit(name, signal, motion)
        if unit is None and _UNIT.search(name):
            raise InputError(
                f"init: {name!r}: its unit is none of the {signal.replace('_', ' ')} of a {motion} machine; "
                f"use one of {', '.join(units_of(signal, motion))}"
            )
        signals.append(Guess(signal, name, unit))
    return Guesses(_time(named["time"]) if "time" in named else None, tuple(signals), (), motion)


def _time(name: str) -> Guess:
    return Guess("time", name, _time_unit(name))


def _time_unit(name: str) -> str | None:
    return next((unit for unit in _units_in(name) if unit in TIME_UNITS), None)


def _unit(name: str, signal: str, motion: str) -> str | None:
    return next((unit for unit in _units_in(name) if unit in units_of(signal, motion)), None)

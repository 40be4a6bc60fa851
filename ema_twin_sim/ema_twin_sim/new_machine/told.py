"""What a draft is based on, in words: what the recording showed, what was given, and what is only assumed."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from ema_bench_replay.traces.header_words import COUNTS, header_words
from ema_bench_replay.units import signal_unit, units_of

from ..model import Model
from ..model.check_comment import ASSUMED, CHECK
from ..model.model_file import ABSENT
from ..quantities import quantity
from .columns import Guess, Guesses
from .model_draft import AS_FINE_AS_NOISE, LAST_DIGIT, ONE_AMPERE_IS
from .torque_constant import GIVEN, TORQUE_OVER_CURRENT
from .travel_per_turn import READ_AS_FORCE

_MOTOR_COUNTS, _OUTPUT_COUNTS = "sensors.motor_encoder_counts", "sensors.output_encoder_counts"
_TOLD = {
    "machine.gear_ratio": "gear ratio",
    "machine.torque_constant": "torque constant",
    "drive.speed_gain": "speed controller's gain",
    "drive.integral_time": "its integral time",
    _MOTOR_COUNTS: "motor encoder",
    _OUTPUT_COUNTS: "output encoder",
    "sensors.current_noise": "noise of the current",
    "sensors.speed_noise": "noise of the speed",
}
_PER = {"1/rev": "turn", "1/m": "metre"}
_HOW = {
    "machine.gear_ratio": "give --gear-ratio",
    "machine.torque_constant": "torques are given in amperes; give --torque-constant from the data sheet",
}


def shown(model: Model, doubts: Mapping[str, str], *, at_output: bool = False) -> list[str]:
    """What the user gave or the columns say, each as ``name value unit``; not what the drafts mark (``doubts``).

    ``at_output``: whether the map reads the motor's position as the output's angle: then its encoder is the output's.
    """
    return [text for path, text in _found(model, doubts, at_output) if not _is_estimate(path, model)]


def estimated(model: Model, doubts: Mapping[str, str]) -> list[str]:
    """What was computed from the recordings, each as ``name value unit``; not what the drafts mark (``doubts``)."""
    return [text for path, text in _found(model, doubts) if _is_estimate(path, model)]


def _found(model: Model, doubts: Mapping[str, str], at_output: bool = False) -> Iterator[tuple[str, str]]:
    """Yield (path, ``name value unit``) of what is neither assumed nor marked."""
    for path, name, value in _values(model, at_output):
        source = model.constants[path].source
        if source != ASSUMED and path not in doubts:
            told = source == TORQUE_OVER_CURRENT or source.startswith(f"{GIVEN}: ")
            yield path, f"{name} {value}" + (f" ({source})" if told else "")


def _is_estimate(path: str, model: Model) -> bool:
    """Whether a number is neither given nor a count, and so has the uncertainty of what it was computed from."""
    return not model.constants[path].source.startswith(GIVEN) and not path.endswith("_encoder_counts")


def assumed(model: Model, doubts: Mapping[str, str]) -> list[str]:
    """What is only assumed, and what to do or to check about it."""
    why = {path: _HOW[path] for path in _TOLD if model.constants[path].source == ASSUMED}
    return [
        f"{name} {value} ({({**doubts, **why})[path]})"
        for path, name, value in _values(model)
        if path in doubts or path in why
    ]


def doubts_of(model: Model, text: str, map_text: str) -> dict[str, str]:
    """By path, what is to be checked about a number that the ``text`` of a model or of its map marks.

    What the user gave is not in doubt here but for its unit: another sentence says what contradicts it.
    """
    found = {}
    for path in _TOLD:
        key, counts = path.partition(".")[2], path.endswith("_encoder_counts")
        place = f"{key.removesuffix('_encoder_counts')}_position: .*counts_per_revolution" if counts else f"{key}:"
        mark = re.search(rf"^ *{place}.*# {CHECK}: (.*)$", map_text if counts else text, re.MULTILINE)
        if mark and (mark[1].startswith(READ_AS_FORCE) or not model.constants[path].source.startswith(GIVEN)):
            found[path] = mark[1]
    return found


def assumed_units(guesses: Guesses) -> list[str]:
    """Units that are not in the header: one sentence for all columns with the same reason, with how to change it."""
    read: dict[str, list[Guess]] = {}
    for guess in guesses.signals:
        if guess.unit is None and not guess.foreign_unit:  # foreign units have a warning
            read.setdefault("no unit in the header", []).append(guess)
        elif guess.unit not in (None, COUNTS) and guess.doubt:
            read.setdefault(guess.doubt, []).append(guess)
    return [*_assumed_clock(guesses.time), *(_assumed_unit(each, why, guesses.motion) for why, each in read.items())]


def _assumed_clock(clock: Guess | None) -> list[str]:
    """What was assumed of a clock whose name has no unit; empty if nothing was."""
    if clock is None or clock.unit is None or not clock.doubt or header_words(clock.column).unit is not None:
        return []
    other = "ms" if clock.unit == "s" else "s"
    return [
        f"{clock.column} in {clock.unit}: {clock.doubt} (otherwise add the unit to the name, as in '{clock.column} "
        f"[{other}]', and run init again)"
    ]


def _assumed_unit(columns: Sequence[Guess], why: str, motion: str) -> str:
    first = next((guess for guess in columns if guess.signal in ("motor_position", "current")), columns[0])
    told = [guess.unit or signal_unit(guess.signal, motion) for guess in columns]
    other = next((unit for unit in units_of(first.signal, motion) if unit not in told), told[0])
    names = ", ".join(f"{guess.column} in {unit}" for guess, unit in zip(columns, told, strict=True))
    return f"{names}: {why} (otherwise add the unit to the name, as in '{first.column} [{other}]', and run init again)"


def _values(model: Model, at_output: bool = False) -> Iterator[tuple[str, str, str]]:
    """Yield (path, name, value with unit) of the constants that a draft may have found.

    ``at_output``: whether the encoder of the motor's position is on the output's shaft.
    """
    for path, told in _TOLD.items():
        held = model.constants[path]
        if at_output and path == _MOTOR_COUNTS:
            told = _TOLD[_OUTPUT_COUNTS]
            held = replace(held, value=held.value * model.value("machine.gear_ratio"))
        if held.source not in ("", ABSENT, AS_FINE_AS_NOISE):  # a position without steps shows no counts
            name, unit = told, model.unit(path)
            if ONE_AMPERE_IS in held.source:
                name, unit = "noise of the torque", signal_unit("motor_torque", model.motion)
            if held.source.startswith(LAST_DIGIT):
                digit = held.source[len(LAST_DIGIT) :].strip(" ()")
                yield path, f"{name.split()[0]} position", f"in steps of {digit} (the last digit of its column)"
            elif path.endswith("_noise") and held.value == 0.0:
                yield path, name, "none (the signal shows no noise)"
            elif unit in _PER:
                yield path, name, f"{held.value:.0f} counts per {_PER[unit]}"
            else:
                yield path, name, f"{held.value:.4g}" if unit == "1" else quantity(held.value, unit)

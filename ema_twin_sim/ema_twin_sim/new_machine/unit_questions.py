"""Questions about units that look wrong: sizes that drives seldom have, and encoder counts that no maker offers.

They are printed as warnings; nothing is decided by them.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence

import numpy as np

from ema_bench_replay.recording import Recording
from ema_bench_replay.traces.header_words import header_words
from ema_bench_replay.units import units_of

from ..criteria import NEARLY_ALL, NEGLIGIBLE
from ..measured.usual_sizes import USUAL, unusual_sizes
from ..measured.way_by_speed import way_by_speed
from .columns import Guess
from .shaft import OWN
from .steps import is_decimal, smallest_step
from .time_unit import SLOWEST_SAMPLES, smaller_unit
from .usual_counts import usual_counts

_POSITIONS = ("motor_position", "output_position")
_WORDS = {"deg": "degrees", "rev": "turns", "rad": "radians"}


def questions_about_units(
    recording: Recording, units: Mapping[str, str | None], foreign: Collection[str]
) -> Iterator[str]:
    """Questions about a recording's units, in words; ``units`` are those of its columns (None: not known).

    ``foreign`` are the signals whose headers tell a unit that is none of theirs: their sizes ask nothing further.
    """
    yield from unusual_sizes(recording, foreign)
    if recording.motion != "rotary" or recording.of_points:
        return
    yield from _by_whole_numbers(recording, units)
    if not recording.has("speed"):  # with a speed, the distance shows it
        yield from _by_counts(recording, units)
        yield from _by_rate(recording)


def questions_about_clock(recordings: Sequence[Recording], clock: Guess | None) -> tuple[str, ...]:
    """A question if the unit in a clock's name makes samples slower than drives are recorded; empty otherwise.

    It would make speeds, inertia and delays wrong by its powers, and nothing else shows it: slow motion is smooth, too.
    A speed that agrees with the position shows that the unit is right.
    """
    if clock is None or clock.unit is None or header_words(clock.column).unit is None:
        return ()
    smaller = smaller_unit(clock.unit)
    slow = [r for r in recordings if not r.of_points and r.sample_period > SLOWEST_SAMPLES]
    if smaller is None or len(slow) < len(recordings) or any(map(_keeps_time, slow)):
        return ()
    return (
        f"{slow[0].name}: samples come every {slow[0].sample_period:g} s by column {clock.column!r}, more slowly than "
        f"most drives are recorded: is it in {smaller}, and read as {clock.unit}? Then speeds, inertia and delays are "
        f"wrong: correct the unit in its name, as in 'time [{smaller}]', and run init again",
    )


def _keeps_time(recording: Recording) -> bool:
    """Whether the speed times the time is the position's way."""
    times = way_by_speed(recording)
    return times is not None and abs(abs(times) - 1.0) < OWN


def _by_whole_numbers(recording: Recording, units: Mapping[str, str | None]) -> Iterator[str]:
    """Questions if a position or a speed without a unit is read in steps of a radian or more, or of that a second.

    No encoder has such steps, and drives tell speeds in whole numbers of turns per minute, or of their own steps.
    """
    for signal in (*_POSITIONS, "speed"):
        step = _step(recording, signal) if units.get(signal) is None else None
        if step is None or step < 1.0 - NEGLIGIBLE:
            continue
        if signal == "speed":
            yield (
                f"{recording.name}: speed goes in steps of {step:.3g} rad/s, as of whole numbers, and no unit is "
                "given; is its column in rpm, or in the drive's own steps? Then add [rpm] to its name, or give its "
                "`factor` in the map"
            )
        else:
            yield (
                f"{recording.name}: {signal} goes in steps of {step:.3g} rad, and no unit is given; does its column "
                f"count an encoder's steps? Then add [counts] to its name, or give `counts_per_revolution` in the map"
            )


def _by_counts(recording: Recording, units: Mapping[str, str | None]) -> Iterator[str]:
    """A question if an encoder's steps give usual counts per turn in another unit, but not in the one it is read in."""
    for signal in _POSITIONS:
        read = units.get(signal)
        step = _step(recording, signal) if read in units_of(signal) else None
        if read is None or step is None or usual_counts(2.0 * math.pi / step) is not None:
            continue
        own = step / units_of(signal)[read]  # in the column's own unit
        if is_decimal(own):
            continue  # the step of a rounded decimal number, not an encoder's
        for unit, size in units_of(signal).items():
            if unit != read and usual_counts(2.0 * math.pi / (own * size)) is not None:
                yield (
                    f"{recording.name}: {signal} goes in steps of {own:.4g} {read}, which no usual encoder has; is its "
                    f"column in {_WORDS.get(unit, unit)}, and read as {read}?"
                )
                return


def _by_rate(recording: Recording) -> Iterator[str]:
    """A question if a position changes faster than motors turn, in more than few samples: a counter starts again."""
    for signal in _POSITIONS:
        if not recording.has(signal):
            continue
        known = np.isfinite(recording.signals[signal])
        steps = np.abs(np.diff(recording.signals[signal][known])) / np.diff(recording.time[known])
        fastest = float(np.quantile(steps, NEARLY_ALL)) if len(steps) else 0.0
        if fastest > USUAL["speed"][1]:
            yield (
                f"{recording.name}: {signal} changes by {fastest:.3g} rad/s, faster than most motors turn; does its "
                "column count an encoder's steps? Then add [counts] to its name, or give `counts_per_revolution` in "
                "the map; if it is in degrees, add [deg]"
            )


def _step(recording: Recording, signal: str) -> float | None:
    """The step in which a signal goes; None if there is none, or no such signal."""
    values = recording.signals.get(signal, np.zeros(0))
    return smallest_step(values[np.isfinite(values)])

"""Find units that are not in the header from the numbers: a position must be the integral of its speed.

If the speed's unit is known, this gives the position's, and a counter's counts per turn; and the other way round. Of a
time without a unit it gives the unit as well.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ema_bench_replay.traces.header_words import COUNTS
from ema_bench_replay.traces.import_map import TIME_UNITS
from ema_bench_replay.units import units_of

from ..criteria import NEGLIGIBLE, SMALL
from ..measured.usual_sizes import USUAL
from ..measured.way_by_speed import without_long_steps
from .columns import Guess, Guesses
from .command_units import commands_with_units, why_no_command
from .compared_ways import differences, is_open, radians, steady
from .products import with_products_units
from .servo_steps import in_steps_of, servo_by_sign_bit, servo_of
from .steps import is_decimal, smallest_step
from .time_unit import time_unit as unit_of_clock
from .time_unit import unit_of_size
from .usual_counts import usual_counts

_USUAL = ("rad", "deg", "rev", "mrad"), ("rad/s", "rpm", "deg/s", "rev/s")
"""Units of position and speed, the more likely first."""


def with_units(guesses: Guesses, numbers: Mapping[str, np.ndarray], gear_ratio: float | None) -> Guesses:
    """The guesses with the units that the numbers (n,) of each column show; other units stay unknown."""
    if guesses.time is None or guesses.of_points or guesses.motion != "rotary":
        return guesses
    clock = guesses.time
    time = numbers[clock.column]
    guesses = with_products_units(guesses, numbers)
    if servo := servo_by_sign_bit(guesses):
        guesses = in_steps_of(servo, guesses, numbers)
    known = guesses.by_signal
    position, speed = known.get("motor_position"), known.get("speed")
    time_unit, time_doubt = clock.unit, clock.doubt
    if time_unit is None:
        time_unit, time_doubt = unit_of_clock(time, _unit_by_motion(time, position, speed, numbers))
    seconds = (time - time[0]) * TIME_UNITS[time_unit] * 1e-9
    changed: dict[str, Guess] = {}
    output = known.get("output_position")
    sized = [each for each in (position, output) if each is not None and not is_open(each)]
    if gear_ratio is None and len(sized) > 1:
        ratio = steady(*differences(*(numbers[each.column] * radians(each) for each in sized)))
        gear_ratio = abs(ratio) if ratio is not None else None
    if position is not None and speed is not None:
        ways = _ways(numbers[position.column], numbers[speed.column], seconds)
        if servo := servo_of(position, speed, numbers, ways):
            guesses = in_steps_of(servo, guesses, numbers)
            known = guesses.by_signal
            position, speed = known["motor_position"], known["speed"]
        if position.unit is None and speed.unit is None and ways is not None and abs(abs(ways) - 1.0) < NEGLIGIBLE:
            position, speed = _alike(position, speed, numbers)
            known |= {"motor_position": position, "speed": speed}
            changed |= {"motor_position": position, "speed": speed}
        changed |= {guess.signal: guess for guess in _by_way(position, speed, ways, gear_ratio)}
        if changed.get("speed", speed).of_output and (asked := known.get("speed_setpoint")) is not None:
            scale = steady(numbers[asked.column], numbers[speed.column])
            if scale is not None and abs(scale - 1.0) < SMALL:  # given like the speed
                known["speed_setpoint"] = changed["speed_setpoint"] = replace(asked, of_output=True)
    motor = changed.get("motor_position", position)
    if motor is not None and output is not None and is_open(output) and not is_open(motor) and gear_ratio:
        turned = numbers[motor.column] * radians(motor) / gear_ratio
        scale = steady(*differences(numbers[output.column], turned))
        if scale is not None and (told := _position_told(output, abs(scale))):
            changed["output_position"] = told
    changed |= commands_with_units({**known, **changed}, numbers)
    signals = tuple(changed.get(guess.signal, guess) for guess in guesses.signals)
    why = why_no_command({guess.signal: guess for guess in signals}, numbers)
    lost = {guess.column: why for guess in signals if guess.signal == "output_command" and why}
    return replace(
        guesses,
        time=replace(clock, unit=time_unit, doubt=time_doubt),
        signals=tuple(guess for guess in signals if guess.column not in lost),
        left=(*guesses.left, *lost),
        lost_commands=lost,
    )


def _alike(position: Guess, speed: Guess, numbers: Mapping[str, np.ndarray]) -> tuple[Guess, Guess]:
    """A position and a speed that share an unknown unit of angle, with the most likely one.

    If only one unit makes the encoder's steps usual, it is that one; otherwise radians, or degrees if the speed in
    radians would be too high for a motor.
    """
    units, alike = units_of("motor_position"), ("rad", "deg", "rev")
    step = smallest_step(numbers[position.column][np.isfinite(numbers[position.column])])
    shown = (
        {} if step is None or is_decimal(step) else {u: usual_counts(2.0 * math.pi / units[u] / step) for u in alike}
    )
    usual = [(unit, counts) for unit, counts in shown.items() if counts]
    fastest = float(np.nanmax(np.abs(numbers[speed.column])))
    doubt = "no unit in the header; position and speed would also agree in other units of angle"
    if len(usual) == 1:
        unit, counts = usual[0]
        doubt = (
            f"no unit in the header; with this one, its steps are those of an encoder with {counts:.0f} counts per turn"
        )
    else:
        unit = "rad" if fastest <= USUAL["speed"][1] else "deg"
    return replace(position, unit=unit, doubt=doubt), replace(speed, unit=f"{unit}/s", doubt=doubt)


def _unit_by_motion(
    time: np.ndarray, position: Guess | None, speed: Guess | None, numbers: Mapping[str, np.ndarray]
) -> str | None:
    """The unit of time in which position and speed agree; None if they do not show it.

    Where only one of them has a unit, the other may have any usual one; without any they share that of the angle.
    """
    if position is None or speed is None or (position.unit == COUNTS and is_open(position)):
        return None
    ways = _ways(numbers[position.column], numbers[speed.column], time - time[0])
    if ways is None:
        return None
    angles, speeds = units_of("motor_position"), units_of("speed")
    if position.unit is None and speed.unit is None:
        return unit_of_size([abs(ways)], NEGLIGIBLE)
    ways_told = [radians(position)] if position.unit is not None else [angles[unit] for unit in ("rad", "deg", "rev")]
    speeds_told = [speeds[speed.unit]] if speed.unit is not None else [speeds[unit] for unit in _USUAL[1]]
    sizes = [abs(ways) * way / by for way in ways_told for by in speeds_told]
    return unit_of_size(sizes, SMALL if len(sizes) == 1 else NEGLIGIBLE)


def _by_way(position: Guess, speed: Guess, ways: float | None, gear_ratio: float | None) -> list[Guess]:
    """Position and speed with the units in which the position is the speed's integral; empty if there are none."""
    if ways is None:
        return []
    shafts = (1.0,) if gear_ratio is None else (1.0, 1.0 / gear_ratio, gear_ratio)
    if speed.unit is not None and is_open(position):
        one = units_of("speed")[speed.unit] * speed.factor / abs(ways)  # rad per unit of the position's column
        for shaft in shafts:
            if told := _position_told(position, one * shaft):
                return [told, replace(speed, of_output=speed.of_output or shaft > 1.0)]
        return [_unusual(position, one, speed)] if position.unit == COUNTS else []
    if speed.unit is not None:
        times = abs(ways) * radians(position) / (units_of("speed")[speed.unit] * speed.factor)
        if abs(times - 1.0) < NEGLIGIBLE:
            return [replace(speed, of_output=position.of_output)]
        if gear_ratio is not None and abs(times / gear_ratio - 1.0) < NEGLIGIBLE:
            return [replace(speed, of_output=True)]  # the motor turns farther than the speed says by the ratio
        return []
    if speed.unit is None:
        positions = (position.unit,) if position.unit not in (None, COUNTS) else _USUAL[0]
        for unit in _USUAL[1]:
            for place in positions if position.unit != COUNTS or position.counts else ():
                agree = units_of("speed")[unit] / (abs(ways) * units_of("motor_position")[place])
                if any(abs(agree * shaft - 1.0) < NEGLIGIBLE for shaft in shafts):
                    doubt = "" if position.unit else "no unit in the header; with it, position and speed agree"
                    return [
                        replace(position, unit=place, doubt=doubt),
                        replace(speed, unit=unit, doubt=doubt and "no unit in the header"),
                    ]
        goes = f"changes {abs(ways):.4g} times as much as the integral of the speed"
        if position.unit is None:
            return [replace(position, origin_doubt=f"it {goes}: what are the units of both?")]
        if not is_open(position):
            return [replace(speed, origin_doubt=f"the position {goes}, which no usual unit explains")]
    return []


def _position_told(position: Guess, one: float) -> Guess | None:
    """The position with the unit, or the counts, whose size is ``one`` [rad]; None if there is none."""
    if position.unit == COUNTS:
        usual = usual_counts(2.0 * math.pi / one)
        return None if usual is None else replace(position, counts=usual)
    for unit in _USUAL[0]:
        if abs(one / units_of("motor_position")[unit] - 1.0) < NEGLIGIBLE:
            return replace(position, unit=unit)
    counts = usual_counts(2.0 * math.pi / one)  # a counter whose name does not say so
    return None if counts is None else replace(position, unit=COUNTS, counts=counts)


def _unusual(position: Guess, one: float, speed: Guess) -> Guess:
    """A counter with counts per turn, by the speed, that no usual encoder has; with another unit of it one may have."""
    counts = 2.0 * math.pi / one
    doubt = f"{counts:.6g} counts per turn by the speed; this is not a usual number"
    units = units_of("speed")
    for unit in _USUAL[1]:
        usual = usual_counts(counts * units[speed.unit or "rad/s"] / units[unit])
        if unit != speed.unit and usual is not None:
            doubt += f", and {usual:.0f} is, which it would be with the speed in {unit}: is {speed.unit} right?"
            break
    return replace(position, counts=round(counts), doubt=doubt)


def _ways(position: np.ndarray, speed: np.ndarray, time: np.ndarray) -> float | None:
    """Distance in the position's unit per unit of distance by the speed; None if the position does not follow it.

    A pause is longer than the parts that are compared usually last: elsewhere so many seconds tell one, and here the
    time may have no unit yet.
    """
    travelled = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(time))])
    part = float(np.median(differences(time)[0]))
    return steady(*differences(*without_long_steps(time, part, position, travelled)))

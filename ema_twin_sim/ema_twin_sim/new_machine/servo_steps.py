"""Bus servos that log whole steps of their own: what a step is, by their columns' names and by the motion.

Their registers have no units in a log: position, velocity and current are whole numbers under the names of the control
table (`present_position`). How many steps of position go by in a second at a speed of one tells which servo it is.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ema_bench_replay.traces.header_words import COUNTS, header_words

from ..criteria import NEGLIGIBLE
from .columns import Guess, Guesses
from .sign_bits import OF_SPEED

WORD = "present"
"""Begins the names of all measured values of these servos, and of no other drive's."""


@dataclass(frozen=True)
class Servo:
    """A family of servos and its steps, from its control table."""

    name: str
    counts: int  # steps of position per turn of the output
    velocity: float  # rpm, a step of velocity
    current: float  # mA, a step of current
    other_currents: str

    @property
    def steps_per_second(self) -> float:
        """Steps of position in a second at a velocity of one step."""
        return self.counts * self.velocity / 60.0


SERVOS = (
    Servo("DYNAMIXEL X", 4096, 0.229, 2.69, "3.36 mA for MX, 1 mA for XL330 and XC330"),
    Servo("Feetech STS", 4096, 60.0 / 4096.0, 6.5, "see the memory table of your model"),
)
"""emanual.robotis.com, control tables of XM430 and MX-64(2.0); Feetech's memory table of the STS3215."""
_BY_SIGN_BIT = SERVOS[1]


def servo_of(position: Guess, speed: Guess, numbers: Mapping[str, np.ndarray], ways: float | None) -> Servo | None:
    """The servo whose steps a position and a speed count, by their names and their motion; None if there is none.

    ``numbers`` (n,) are each column's values, ``ways`` the distance in the position's own steps per unit of the
    distance by the speed.
    """
    if ways is None or not all(_in_steps(guess, numbers) for guess in (position, speed)):
        return None
    return next((s for s in SERVOS if math.isclose(abs(ways), s.steps_per_second, rel_tol=NEGLIGIBLE)), None)


def servo_by_sign_bit(guesses: Guesses) -> Servo | None:
    """The servo whose registers a trace holds if the sign of a speed is a bit of it; None if there is none."""
    return _BY_SIGN_BIT if OF_SPEED in guesses.sign_bits.values() else None


def in_steps_of(servo: Servo, guesses: Guesses, numbers: Mapping[str, np.ndarray]) -> Guesses:
    """The guesses with the units of a servo's steps for its position, its speed and its current."""
    shown = f"whole numbers, and their motion, are those of a {servo.name} servo"
    if servo.steps_per_second == 1.0:
        shown = (
            f"whole numbers, as a {servo.name} servo logs; in other steps, such as 0.1 degrees, both would agree too"
        )
    size = f"a step of the current of a {servo.name} servo; {servo.other_currents}"

    by_bit = servo_by_sign_bit(guesses) is servo
    if by_bit:
        shown = f"whole numbers, beside a speed whose bit {OF_SPEED} is the sign, as a {servo.name} servo logs"

    def told(guess: Guess) -> Guess:
        if not _in_steps(guess, numbers, named=not by_bit):
            return guess
        if guess.signal == "motor_position":
            return replace(guess, unit=COUNTS, counts=float(servo.counts), doubt=shown)
        if guess.signal == "speed":
            return replace(guess, unit="rpm", factor=servo.velocity, doubt=shown)
        return replace(guess, unit="mA", factor=servo.current, doubt=size) if guess.signal == "current" else guess

    return replace(guesses, signals=tuple(told(guess) for guess in guesses.signals))


def _in_steps(guess: Guess, numbers: Mapping[str, np.ndarray], *, named: bool = True) -> bool:
    """Whether a column has no unit, all that was measured is whole numbers, and its name is one of these servos'.

    The name need not be if the servo is known otherwise (``named`` is False).
    """
    measured = numbers[guess.column][np.isfinite(numbers[guess.column])]
    known = (not named or WORD in header_words(guess.column).words) and guess.unit in (None, COUNTS)
    return known and len(measured) > 0 and bool(np.array_equal(measured, np.round(measured)))

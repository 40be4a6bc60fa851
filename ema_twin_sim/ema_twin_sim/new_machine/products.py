"""Drives whose logs have no units, recognised by how they name their columns."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ema_bench_replay.traces.header_words import header_words

from ..measured.usual_sizes import USUAL
from .columns import Guess, Guesses


@dataclass(frozen=True)
class Product:
    """A drive that logs positions in turns and speeds in turns per second, with the column names that only it has.

    All names of one of the groups must be there, each as the end of a column's name. A column whose name says the
    drive's is this drive's too, whatever the others are.
    """

    name: str
    known_by: tuple[tuple[tuple[str, ...], ...], ...]

    def wrote(self, header: Sequence[str]) -> bool:
        """Whether a header is this drive's."""
        words = [header_words(column).words for column in header]
        return any(all(any(own[-len(ends) :] == ends for own in words) for ends in group) for group in self.known_by)

    def names(self, column: str) -> bool:
        """Whether a column's name says that it is of this drive."""
        return self.name.lower() in header_words(column).words


IN_TURNS = (
    Product(
        "ODrive",
        (
            (("pos", "estimate"),),
            (("vel", "estimate"),),
            (("fet", "temp"), ("bus", "voltage")),
            (("fet", "temperature"), ("bus", "voltage")),
        ),
    ),
    Product("moteus", ((("q", "current"), ("velocity",)), (("q", "current"), ("position",)))),
)
"""ODrive from firmware 0.5 on (docs.odriverobotics.com), whose CAN messages tell the FET's temperature and the bus's
voltage too; moteus (its register reference: revolutions of the output)."""
_UNITS = dict.fromkeys(("motor_position", "output_position", "output_command"), "rev") | dict.fromkeys(
    ("speed", "speed_setpoint"), "rev/s"
)


def with_products_units(guesses: Guesses, numbers: Mapping[str, np.ndarray]) -> Guesses:
    """The guesses; positions and speeds without a unit are in turns if a drive that logs turns wrote them.

    ``numbers`` (n,) are each column's values: older ODrives logged counts, and as turns they would be faster than any
    motor.
    """
    header = [guess.column for guess in guesses.signals] + list(guesses.left)
    speeds = [np.abs(numbers[guess.column]).max() for guess in guesses.signals if guess.signal == "speed"]
    if any(2.0 * math.pi * fastest > USUAL["speed"][1] for fastest in speeds):
        return guesses
    of_all = next((product for product in IN_TURNS if product.wrote(header)), None)

    def told(guess: Guess) -> Guess:
        product = of_all or next((product for product in IN_TURNS if product.names(guess.column)), None)
        if product is None or guess.unit is not None or guess.signal not in _UNITS:
            return guess
        return replace(guess, unit=_UNITS[guess.signal], doubt=f"no unit in the header; {product.name} logs turns")

    return replace(guesses, signals=tuple(told(guess) for guess in guesses.signals))

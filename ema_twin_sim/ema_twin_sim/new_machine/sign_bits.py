"""Registers whose highest bit is the sign, as Feetech servos have them: -50 is logged as 32768 + 50.

Read as they are, they are speeds of tens of thousands that no position follows. No key of an import map tells such a
bit.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ema_bench_replay.traces.header_words import HeaderWords

from ..criteria import PART
from .column_quantity import word_quantity

OF_SPEED = 15
_BITS = (OF_SPEED, 10)
"""Of a speed and of a load in Feetech's memory table of the STS3215. No value of either comes near half of its bit, but
for a load of more than half the servo's."""
_SIGNED = ("speed", "current", "torque")
_LOAD = ("load",)


def sign_bits(names: Sequence[HeaderWords], numbers: Mapping[str, np.ndarray]) -> dict[str, int]:
    """By the name of each column that holds the sign in a bit, which one that is. What has a unit is no register."""
    told = [read for read in names if read.unit is None and (word_quantity(read.words) in _SIGNED or _is_load(read))]
    found = {
        read.name: sign_bit(numbers[read.name], _BITS if _is_load(read) else (OF_SPEED,))
        for read in told
        if read.name in numbers
    }
    return {name: bit for name, bit in found.items() if bit is not None}


def sign_bit(values: np.ndarray, bits: Sequence[int] = _BITS) -> int | None:
    """Which of the ``bits`` of whole numbers (n,) is their sign; None if none is.

    Numbers with that bit come and go, and without it they are about as large as the others, down to small ones.
    """
    known = values[np.isfinite(values)]
    if not len(known) or known.min() < 0.0 or not np.array_equal(known, np.round(known)):
        return None
    return next((bit for bit in bits if _is_sign(known, 2.0**bit)), None)


def how_to_decode(bits: Mapping[str, int]) -> list[str]:
    """What such columns are and what to do about them, a sentence for each bit."""
    return [
        f"{', '.join(name for name, each in bits.items() if each == bit)}: not used, since its whole numbers look like "
        f"a register whose bit {bit} is the sign, as Feetech servos have it ({2**bit + 50} for -50); to use it, write "
        f"{2**bit} minus the number in place of each number from {2**bit} on, and run init again"
        for bit in sorted({*bits.values()}, reverse=True)
    ]


def _is_load(read: HeaderWords) -> bool:
    return tuple(word for word in read.words if not word.isdigit()) in (_LOAD, ("present", *_LOAD))


def _is_sign(known: np.ndarray, size: float) -> bool:
    """Whether numbers (n,) from ``size`` on are the negative ones."""
    negative = known >= size
    below, beyond = known[~negative], known[negative] - size
    if np.count_nonzero(np.diff(negative)) < 2 or max(below.max(), beyond.max()) >= 0.5 * size:
        return False
    return bool(below.max() >= PART * beyond.max() >= beyond.min() and beyond.max() >= PART * below.max())

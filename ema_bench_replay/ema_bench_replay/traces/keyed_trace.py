"""Refuse the traces of CODESYS and of controllers built on it, which hold keys and values and no table."""

from __future__ import annotations

import re
from pathlib import Path

from ema_bench_replay.errors import InputError

_FIRST_LINE = re.compile(rb"\s*\[key\]\s*;\s*\[value\]\s*\n", re.IGNORECASE)


def refuse_keyed_trace(path: Path, first: bytes) -> None:
    """Raise InputError if a file that begins with these bytes is such a trace."""
    if _FIRST_LINE.match(first):
        raise InputError(
            f"{path}: is a trace of CODESYS (also of ctrlX): keys and values, and the samples of one variable below "
            "those of another; write a table with one column for the time and one for each variable, as in "
            "'time [ms];motor position [rad];motor current [A]', and one line for each sample"
        )

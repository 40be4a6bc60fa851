"""How to use a position in a unit of length on a rotary machine, such as that of the nut of a screw."""

from __future__ import annotations

import math

from ema_bench_replay.traces.header_words import header_words
from ema_bench_replay.units import units_of

from .column_quantity import has_word
from .column_words import SETPOINT
from .columns import Guesses
from .map_draft import quoted


def how_to_use_length(name: str, guesses: Guesses) -> str:
    """What to write into the map, with the screw's lead; empty if a column is no measured position.

    Empty too if the output's position is known, and for all but the first such column: the map holds one.
    """
    if name != guesses.other_motion[0] or any(guess.signal == "output_position" for guess in guesses.signals):
        return ""
    read = header_words(name)
    size = units_of("output_position", "linear").get(read.unit or "")
    if size is None or read.quantity != "position" or has_word(read.words, SETPOINT):
        return ""
    return (
        f"if a screw moves it, add the line `output_position: {{columns: [{quoted(name)}], unit: rad, factor: …}}` to "
        f"the map, with {2.0 * math.pi * size:.6g} divided by the screw's lead in m as its factor; "
    )

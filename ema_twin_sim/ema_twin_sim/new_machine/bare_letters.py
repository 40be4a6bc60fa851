"""Speeds and positions that one letter alone tells, such as ``v``: not used if the motion contradicts it."""

from __future__ import annotations

from collections.abc import Sequence

from ema_bench_replay.recording import Recording
from ema_bench_replay.traces.header_words import header_words

from .columns import Guesses
from .position_beside_speed import share_beside_speed
from .signal_columns import is_a_letter

_MOTIONS = ("speed", "motor_position")


def contradicted_letter(recordings: Sequence[Recording], guesses: Guesses) -> tuple[str, str]:
    """The signal of a bare letter that is not used, and why; both empty if there is none.

    A letter is none if more than half of the position's way is not the speed's. Of two letters the speed goes.
    """
    found = guesses.by_signal
    letters = [signal for signal in _MOTIONS if signal in found and is_a_letter(header_words(found[signal].column))]
    if not {*_MOTIONS} <= found.keys() or not letters:
        return "", ""
    share = share_beside_speed(recordings)
    if share <= 0.5:
        return "", ""
    signal = letters[0]
    what = signal.removeprefix("motor_")
    return signal, (
        f"not used: {100.0 * share:.0f} % of the way of {found['motor_position'].column} is not that of "
        f"{found['speed'].column}, and a letter alone does not tell a {what} (if it is one, say so in its name, as in "
        f"'motor {what}', and run init again)"
    )

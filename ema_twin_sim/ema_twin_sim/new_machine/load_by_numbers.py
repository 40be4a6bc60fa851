"""Which torque is measured behind the machine, though no name says so: the numbers of the current and the motion do.

It is the one torque beside a current, or one beside a torque that the drive computed from the current.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from ema_bench_replay.recording import Recording

from .columns import Guess, Guesses
from .torque_beside_current import counts_against, measured_behind, not_proportional, with_load_as_torque


def load_by_numbers(
    recordings: Sequence[Recording], guesses: Guesses, read: Callable[[Guesses], Sequence[Recording]]
) -> tuple[Guess | None, Mapping[str, str]]:
    """The column to be taken for the load, with the reason, or None; and by column, why other torques are not used.

    ``read`` reads the recordings as other guesses say.
    """
    found = {guess.signal: guess for guess in guesses.signals}
    current, torque = found.get("current"), found.get("motor_torque")
    if current is None or torque is None or "load_torque" in found:
        return None, {}
    if torque.command or torque.magnitude or current.magnitude:
        return None, {}
    if not_proportional(recordings) is not None:
        why = "" if torque.of_motor else _behind(recordings, current)
        return (replace(torque, signal="load_torque", of_output=True, shaft_doubt=why), {}) if why else (None, {})
    left = {}
    for other in guesses.other_torques:
        tried = [with_load_as_torque(recording) for recording in read(guesses.with_load(other))]
        if not_proportional(tried) is None:
            continue  # the motor's torque once more
        if why := _behind(tried, current):
            return replace(other, shaft_doubt=why), {}
        left[other.column] = (
            f"not used: {torque.column} goes with {current.column}, and this one is not shown to be the load (if it "
            "is, say so in its name, as in 'load torque [N m]', and run init again)"
        )
    return None, left


def _behind(recordings: Sequence[Recording], current: Guess) -> str:
    """Why the motor's torque, as read, is measured behind the machine; empty if nothing shows that."""
    left = measured_behind(recordings)
    if left is not None:
        return (
            "taken for the load, measured behind the machine, since together with inertia and friction it explains "
            f"{current.column} ({100.0 * left:.0f} % is left)"
        )
    if counts_against(recordings):
        return f"taken for the load, measured behind the machine, since {current.column} falls when it rises"
    return ""

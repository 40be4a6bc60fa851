"""Which torque is measured behind the machine, though no name says so: the numbers of the current and the motion do.

It is the one torque beside a current, or one beside a torque that is the motor's by its name or by the current.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from ema_bench_replay.recording import Recording
from ema_bench_replay.traces.header_words import header_words
from ema_bench_replay.units import signal_unit

from ..measured.load_sensor import times_current
from .column_quantity import has_word
from .column_words import COMPUTED, ESTIMATED
from .columns import Guess, Guesses
from .map_draft import quoted
from .torque_beside_current import (
    counts_against,
    measured_behind,
    not_filtered,
    not_proportional,
    with_load_as_torque,
    with_motors_torque_as_load,
)


def load_by_numbers(
    recordings: Sequence[Recording], guesses: Guesses, read: Callable[[Guesses], Sequence[Recording]]
) -> tuple[Guess | None, Mapping[str, str]]:
    """The column to be taken for the load, with the reason, or None; and by column, why other torques are not used.

    ``read`` reads the recordings as other guesses say.
    """
    found = guesses.by_signal
    current, torque = found.get("current"), found.get("motor_torque")
    if torque is None or torque.command or torque.magnitude or "load_torque" in found:
        return None, {}
    if current is not None and current.magnitude:
        return None, {}
    drive = current or torque
    if current is not None and _differ(recordings):
        why = "" if torque.of_motor else _behind(recordings, drive)
        return (replace(torque, signal="load_torque", of_output=True, shaft_doubt=why), {}) if why else (None, {})
    left = {}
    for other in guesses.other_torques:
        tried = [with_load_as_torque(recording) for recording in read(guesses.with_load(other))]
        if not _differ(tried):
            continue  # the motor's torque once more
        if why := _behind(tried, drive):
            return replace(other, shaft_doubt=why), {}
        motors = "is the motor's by its name" if current is None else f"goes with {current.column}"
        left[other.column] = (
            f"not used: {torque.column} {motors}, and this one is not shown to be the load (if it "
            "is, say so in its name, as in 'load torque [N m]', and run init again)"
        )
    return None, left


def doubted_motors_torque(recordings: Sequence[Recording], guesses: Guesses) -> tuple[str, str]:
    """What to check about a torque beside a current that is read as the motor's and may be a load's; empty if nothing.

    Second, what to do if it is the load's, with the line for the map.
    """
    found = guesses.by_signal
    current, torque = found.get("current"), found.get("motor_torque")
    if current is None or torque is None or torque.of_motor or torque.command or "load_torque" in found:
        return "", ""
    unit = torque.unit or signal_unit("load_torque", guesses.motion)
    share = not_filtered(recordings)
    if share is not None:
        line = f"load_torque: {{columns: [{quoted(torque.column)}], unit: {unit}, shaft: output}}"
        return (
            f"{100.0 * share:.0f} % of it does not follow {current.column}: is it the motor's, or a sensor's behind "
            "the machine?",
            f"if a sensor behind the machine measured it, replace its line of the map by `{line}`",
        )
    points = [with_motors_torque_as_load(recording) for recording in recordings if recording.of_points]
    if not points or _is_computed(torque) or times_current(points) is not None:
        return "", ""
    return (
        f"each row is an operating point, where a torque measured at the shaft goes with {current.column} too: is it "
        "the motor's, or a dynamometer's?",
        f"if a dynamometer or a load sensor measured it, say so in its name, as in 'load torque [{unit}]', and run "
        "init again",
    )


def _is_computed(torque: Guess) -> bool:
    """Whether a torque's name says that a drive estimated or computed it."""
    return has_word(header_words(torque.column).words, f"{COMPUTED}|{ESTIMATED}")


def _differ(recordings: Sequence[Recording]) -> bool:
    """Whether a torque is not that which the drive makes of the current, as far as the numbers tell."""
    return not_proportional(recordings) is not None or not_filtered(recordings) is not None


def _behind(recordings: Sequence[Recording], drive: Guess) -> str:
    """Why the motor's torque, as read, is measured behind the machine that a current drives; empty if nothing shows it.

    ``drive`` is the column that is read as the current.
    """
    left = measured_behind(recordings)
    if left is not None:
        return (
            "taken for the load, measured behind the machine, since together with inertia and friction it explains "
            f"{drive.column} ({100.0 * left:.0f} % is left)"
        )
    if counts_against(recordings):
        return f"taken for the load, measured behind the machine, since {drive.column} falls when it rises"
    return ""

"""Whether a current and a torque recorded together are one thing in two units, as a motor's are, or two.

On a dynamometer the torque's sensor is behind the machine: the motor's current drives that load, inertia and friction.
The current of a supply is its power over its voltage, and that of an induction motor magnetises it too: then the torque
says what drives the machine.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ema_bench_replay.recording import Recording

from ..criteria import FEWEST_ROWS, LIKELY, MOSTLY, NEGLIGIBLE, SMALL, TOO_MUCH
from ..measured.load_sensor import falls_with_load, left_of_the_drive
from ..reading_noise import reading_noise

_NEIGHBOURS = 5  # samples before and after, over which a drive may filter or delay what it reports


class Proportion(NamedTuple):
    """The factor [N m/A] by which a torque changes with the current, and what it leaves of the torque's changes (rms).

    ``left`` is a share, and ``surely`` says that neither sensor's noise explains it.
    """

    factor: float
    left: float
    surely: bool


def proportion(recordings: Sequence[Recording]) -> Proportion | None:
    """How the motor's torque goes with the current, whatever its offset; None if that cannot be told.

    Operating points, whose rows come in any order, tell no noise.
    """
    both = [r for r in recordings if r.has("current", "motor_torque")]
    parts = [_known(r) for r in both]
    current, torque = np.concatenate(parts, axis=1) if parts else np.zeros((2, 0))
    if len(torque) < FEWEST_ROWS or not (_changes(current) and _changes(torque)):
        return None
    changes = current - current.mean()
    factor = float(changes @ torque / (changes @ changes))
    left, size = float(np.std(torque - factor * current)), float(np.std(torque))
    noises = [
        math.hypot(reading_noise(torque), factor * reading_noise(current))
        for (current, torque), recording in zip(parts, both, strict=True)
        if not recording.of_points
    ]
    seen = left > NEGLIGIBLE * math.sqrt(float(np.mean(torque**2)))
    surely = seen and left > max(SMALL * size, TOO_MUCH * max(noises, default=0.0))
    return Proportion(factor, left / size, surely)


def _changes(values: np.ndarray) -> bool:
    """Whether values (n,) change by more than their mean is rounded."""
    return float(np.std(values)) > math.sqrt(np.finfo(float).eps) * float(np.abs(values).max())


def not_proportional(recordings: Sequence[Recording]) -> float | None:
    """The share of the torque's changes (rms) that no factor times the current and no offset explain; None if small.

    Small is what both sensors' noise explains.
    """
    found = proportion(recordings)
    return found.left if found is not None and found.surely else None


def not_filtered(recordings: Sequence[Recording]) -> float | None:
    """The share of the torque's changes (rms) that the current at and near each sample does not explain; None if small.

    A drive computes its torque of its current, which it may filter or delay: then little is left but both sensors'
    noise, which is white. What a sensor measures lacks the motor's friction and inertia, so more is left, and that goes
    with the motion. Operating points, whose rows come in any order, have no neighbours.
    """
    shares = [_left_beside_neighbours(_known(r)) for r in recordings if r.has("current", "motor_torque")]
    return max(filter(None, shares), default=None) if not any(r.of_points for r in recordings) else None


def _left_beside_neighbours(both: np.ndarray) -> float | None:
    """The same of current and torque (2, n) of one recording."""
    current, torque = both
    if len(torque) < 2 * _NEIGHBOURS + FEWEST_ROWS or not (_changes(current) and _changes(torque)):
        return None
    near = np.lib.stride_tricks.sliding_window_view(current - current.mean(), 2 * _NEIGHBOURS + 1)
    inner = torque[_NEIGHBOURS:-_NEIGHBOURS] - torque.mean()
    columns = np.column_stack([near, np.ones(len(near))])
    rest = inner - columns @ np.linalg.lstsq(columns, inner, rcond=None)[0]
    left = float(np.std(rest))
    if left <= max(SMALL * float(np.std(torque)), LIKELY * reading_noise(rest)):
        return None
    return left / float(np.std(torque))


def measured_behind(recordings: Sequence[Recording]) -> float | None:
    """The share of the current's changes (rms) that the torque as a load and the motion leave; None if that is no load.

    It is one if they leave little, and the motion explains most of what the torque alone leaves.
    """
    left = left_of_the_drive([with_motors_torque_as_load(r) for r in recordings if r.has("current", "motor_torque")])
    if left is None:
        return None
    alone, with_motion = left
    return with_motion if with_motion <= min(SMALL, (1.0 - MOSTLY) * alone) else None


def counts_against(recordings: Sequence[Recording]) -> bool:
    """Whether the current falls where the torque rises, in motion both ways: then a load's sensor has the other sign.

    What the motor makes of its current rises with it. A current without sign, as of a supply or of a motor that is
    magnetised too, falls where a torque that is always negative rises.
    """
    both = [r for r in recordings if r.has("current", "motor_torque")]
    current = np.concatenate([_known(r)[0] for r in both]) if both else np.zeros(0)
    if not len(current) or min(np.mean(current < 0.0), np.mean(current > 0.0)) < NEGLIGIBLE:
        return False
    return falls_with_load([with_motors_torque_as_load(r) for r in both])


def with_load_as_torque(recording: Recording) -> Recording:
    """The recording with its load, if it has one, in place of the motor's torque, to be judged as such.

    Without a current, the motor's torque stands in place of that, whatever its unit: it drives the machine too.
    """
    signals = {name: values for name, values in recording.signals.items() if not name.endswith("_torque")}
    if "current" not in signals and recording.has("motor_torque"):
        signals["current"] = recording.signals["motor_torque"]
    if recording.has("load_torque"):
        signals["motor_torque"] = recording.signals["load_torque"]
    return replace(recording, signals=signals)


def with_motors_torque_as_load(recording: Recording) -> Recording:
    """The recording with the motor's torque as its load."""
    signals = dict(recording.signals)
    signals["load_torque"] = signals.pop("motor_torque")
    return replace(recording, signals=signals)


def _known(recording: Recording) -> np.ndarray:
    """Current and torque (2, n) where both are known."""
    both = np.stack([recording.signals["current"], recording.signals["motor_torque"]])
    return both[:, np.isfinite(both).all(axis=0)]

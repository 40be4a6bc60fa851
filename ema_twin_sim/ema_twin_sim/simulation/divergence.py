"""Find when a simulation diverges, and which of its states diverged first."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from ema_bench_replay.errors import InputError

from ..plant.layout import OUT, Fine
from ..plant.planetary.layout import PLANETS, ROW
from .fidelity import FineParts

_FASTEST = 1e7
"""rad/s of any shaft or wheel: a hundred times the largest speed limit of a drive."""
_MOST_CURRENT = 1e7
"""A."""
_MOST_BENT = 1e7
"""rad, bristle deflection."""
_RESOLUTION = 500
"""ns, accuracy of the time found."""

States = dict[str, tuple[float, float, str]]
"""By name: value, largest allowed value, unit."""


def states_of(state: np.ndarray, fine: Fine, parts: FineParts) -> States:
    """The states that can diverge."""
    held = state[0]
    found: States = {
        "the motor's speed": (held["motor_speed"], _FASTEST, "rad/s"),
        "the output's speed, at the fast shaft": (held["output_speed"], _FASTEST, "rad/s"),
        "the current": (held["current"], _MOST_CURRENT, "A"),
        "the bristle of dry friction": (held["bristle"], _MOST_BENT, "rad"),
        "the output's bristle": (held["output_bristle"], _MOST_BENT, "rad"),
    }
    if parts.planetary:
        found["the sun's speed"] = (fine.train_states[0]["sun_speed"], _FASTEST, "rad/s")
        found["the carrier's speed"] = (fine.train_states[0]["carrier_speed"], _FASTEST, "rad/s")
        for planet, speed in enumerate(fine.lanes[ROW["SPIN_SPEED"] :][:PLANETS]):
            found[f"the speed of planet {planet + 1}"] = (speed, _FASTEST, "rad/s")
    if parts.switching:
        for phase in "uvw":
            current = fine.winding_states[0][f"phase_current_{phase}"]
            found[f"the current of phase {phase}"] = (current, _MOST_CURRENT, "A")
    return found


def looks_lost(row: np.ndarray) -> bool:
    """Whether a twin's sample (signals,) is out of bounds: divergence of any state soon shows in the motor's."""
    return not (abs(row[OUT.current]) <= _MOST_CURRENT and abs(row[OUT.speed]) <= _FASTEST)


def is_lost(states: States) -> bool:
    """Whether one of them exceeds its bound, or is not a number."""
    return not all(abs(value) <= most for value, most, _ in states.values())


def refuse_divergence(
    states_after: Callable[[int, float], States], stamps: np.ndarray, first: float, place: str
) -> None:
    """Raise InputError with the time and the state that diverged first.

    ``states_after`` simulates again from ``first`` [s since the start], where all states were valid: over whole
    intervals of ``stamps`` [ns] (n,), and then a share of the next one.
    """
    sound, lost = 0, len(stamps) - 1  # intervals
    while lost - sound > 1:
        middle = (sound + lost) // 2
        sound, lost = (sound, middle) if is_lost(states_after(middle, 0.0)) else (middle, lost)
    interval = float(stamps[lost] - stamps[sound])
    low, high = 0.0, 1.0
    while (high - low) * interval > _RESOLUTION:
        middle_share = 0.5 * (low + high)
        low, high = (low, middle_share) if is_lost(states_after(sound, middle_share)) else (middle_share, high)
    states = states_after(sound, high)
    worst = max(states, key=lambda name: _beyond(*states[name][:2]))
    value, most, unit = states[worst]
    time = first + (float(stamps[sound] - stamps[0]) + high * interval) * 1e-9
    what = f"{worst} is beyond {most:g} {unit}" if math.isfinite(value) else f"{worst} is no finite number"
    raise InputError(
        f"{place} diverges: {what} {time:.6f} s after the start; its constants do not belong together: check inertias, "
        "stiffness, damping and friction, and what effects of your own return there"
    )


def _beyond(value: float, most: float) -> float:
    """By how much a state exceeds its bound; not a number counts as largest."""
    return abs(value) / most if math.isfinite(value) else math.inf

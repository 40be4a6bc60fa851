"""What the user says about a machine."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Given:
    """What the user said about the machine; None for what was not said."""

    name: str
    gear_ratio: float | None = None
    torque_constant: float | None = None  # N m/A, or N/A if the machine is linear and its way per turn was not said
    shaft: str | None = None  # of the motor's position: motor or output
    travel_per_turn: float | None = None  # m of a slide per turn of its motor

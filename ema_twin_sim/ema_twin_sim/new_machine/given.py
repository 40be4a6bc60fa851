"""What a person says of a machine."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Given:
    """What a person said of the machine; None where they did not."""

    name: str
    gear_ratio: float | None = None
    torque_constant: float | None = None  # N m/A, or N/A where the machine is linear
    shaft: str | None = None  # of the motor's position: motor or output

"""The definition of a machine constant: its place in a model file, its unit, its bounds."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Constant:
    """One constant: its place in a model file, its unit and its bounds."""

    part: str
    name: str
    unit: str
    lower: float
    upper: float
    description: str
    absent: float | None = None  # value if there is none, or it is unknown, in a model with a single inertia
    optional: bool = False  # may be left out: the machine then has none
    kind: str = ""  # the fidelity that it belongs to; other models do not have it
    everywhere: bool = False  # but models of other fidelities may have this one, too
    usual: float | None = None  # default if a model of that fidelity gives none

    @property
    def path(self) -> str:
        """``part.name``, as in error messages and ROS parameters."""
        return f"{self.part}.{self.name}"

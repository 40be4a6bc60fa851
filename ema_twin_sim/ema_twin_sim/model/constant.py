"""What a constant of a machine is: its place in a model file, its unit, its bounds."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Constant:
    """One constant: where it stands in a model file, its unit and its bounds."""

    part: str
    name: str
    unit: str
    lower: float
    upper: float
    description: str
    absent: float | None = None  # stands for having none, or knowing none, where all inertia is one number
    optional: bool = False  # no value stands for having none
    kind: str = ""  # the fidelity that it belongs to; models of another have none of it
    everywhere: bool = False  # but models of another may have this one too
    usual: float | None = None  # what it is where a model of that fidelity gives none

    @property
    def path(self) -> str:
        """``part.name``, as in error messages and ROS parameters."""
        return f"{self.part}.{self.name}"

"""Whether a model knows what torque an acceleration needs."""

from __future__ import annotations

import math

from ..model import Model


def of_unknown_inertia(model: Model) -> bool:
    """Whether the torque that an acceleration needs is open, or the current that gives it."""
    names = [*(f"{part}_inertia" for part in ("motor", "gearbox", "output")), "torque_constant"]
    return any(math.isinf(model.constants[f"machine.{name}"].tolerance) for name in names)

"""The numbers that take seconds to measure; a test compares the page with them."""

from __future__ import annotations

from . import drives, efficiency, energies, friction_coefficient, mesh_stiffness, phase_currents
from .number import Number


def quick_numbers() -> dict[str, Number]:
    """All but those of the integrated train, whose runs take a minute."""
    found: dict[str, Number] = {}
    for figure in (mesh_stiffness, friction_coefficient, efficiency, energies, phase_currents, drives):
        found |= figure.numbers()
    return found

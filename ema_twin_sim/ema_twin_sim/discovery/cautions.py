"""Warnings that accompany a finding."""

from __future__ import annotations

from collections.abc import Mapping

from ..criteria import NEARLY_ALL, SMALL
from ..listing import listed


def of_open_constants() -> str:
    """Warning for a model with open constants: what an effect must achieve to be named, and why."""
    return (
        "your model has unknown constants, and fitting them can hide a missing effect. An effect is named only if less "
        f"than {100.0 * SMALL:.0f} % of the drive's torque remains unexplained; constants from a data sheet help"
    )


def of_wrong_constants(off: Mapping[str, float], removed: float | None, model: str) -> tuple[str, ...]:
    """Warning that constants of a ``model`` may be all that is wrong with it; empty otherwise.

    ``off`` is by how much of itself each one ended away from the file, ``removed`` the share of the excess above the
    noise that fitting the constants removes.
    """
    if not off or removed is None or removed < NEARLY_ALL:
        return ()
    each = listed(f"{name} {100.0 * share:+.0f} %" for name, share in off.items())
    return (
        f"constants other than in the file of {model} explain {100.0 * removed:.1f} % of the error beyond the noise: "
        f"{each}. If the file is wrong there, nothing else need be missing: correct it, or discover again with the "
        "model that is written now",
    )


ALONE = ("with one recording the result is not validated on unseen data; give several",)
ONE_DIRECTION = (
    "nothing reverses here: in one direction a constant load, asymmetric friction and dry friction are the same "
    "torque, so the one that is named may be one of the others; record a motion in both directions",
)
WITHOUT_TORQUE = (
    "no current and no torque was recorded: play, delays and angles are absolute; torques, stiffnesses and dampings "
    "scale with the inertia in the model file, and are wrong by the same factor as it is",
)
"""Warning for recordings with both encoders but no torque or current."""

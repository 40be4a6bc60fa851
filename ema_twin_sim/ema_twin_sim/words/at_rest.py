"""A sentence on an unexplained torque that is mostly where the machine stands still."""

from __future__ import annotations

from ..comparison.beyond_noise import beyond_noise
from ..comparison.compare import Comparison
from ..quantities import quantity

_TORQUE = "unexplained_torque"


def at_rest_sentence(comparison: Comparison) -> str:
    """The sentence; empty if that torque is within the noise, or not mostly at standstill."""
    found = comparison.at_rest
    if found is None or _TORQUE not in beyond_noise(comparison.input, comparison.overall):
        return ""
    error = comparison.overall[_TORQUE]
    rest, motion = (
        quantity(times * error["rmse"], error["unit"]) for times in (found.rest_over_all, found.motion_over_all)
    )
    return (
        f"{100.0 * found.of_squares:.0f} % of the squared error of the unexplained torque is where the machine stands "
        f"still ({100.0 * found.of_samples:.3g} % of the samples): RMSE {rest} there, {motion} in motion. There the "
        "machine holds torques at which the model would move: its friction is larger at rest than in motion, or the "
        "model lacks a load"
    )

"""The relative torque (or force) error in words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from .output import say

if TYPE_CHECKING:  # its filters take a second to import
    from ..comparison.torque_error import TorqueError


def show_torque_errors(errors: Mapping[str, TorqueError], motion: str, model: str = "") -> None:
    """Print the relative error between the torque that the motion needs and the drive's, one line per recording.

    Papers report the error in this form. Standstill counts, where friction may hold any torque.
    """
    what = "force" if motion == "linear" else "torque"
    for name, error in errors.items():
        of = f"{name} ({model})" if model else name
        below = f"{_percent(error.filtered)} below {error.band:g} Hz, "
        if not error.is_filtered:
            if error.unfiltered > 1.0:  # the noise of the acceleration, which a filter removes
                continue
            below = f"sampled too slowly for a filter of {error.band:g} Hz: "
        say(f"Relative {what} error of {of}, standstill included: {below}{_percent(error.unfiltered)} unfiltered")


def _percent(share: float) -> str:
    """``3.52 %``, and ``7340 %``: three digits where there are that many before the point."""
    value = 100.0 * share
    return f"{float(f'{value:.3g}'):.0f} %" if value >= 100.0 else f"{value:.2f} %"

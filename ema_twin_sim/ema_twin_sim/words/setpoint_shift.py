"""A sentence on a position error in proportion to the speed: what it most likely is, and why no effect is named."""

from __future__ import annotations

from ..comparison.beyond_noise import beyond_noise
from ..comparison.compare import Comparison
from ..comparison.setpoint_shift import SetpointShift
from ..quantities import quantity


def shift_sentence(comparison: Comparison) -> str:
    """What a position error in proportion to the speed most likely is; empty without one above the sensors' noise."""
    shift = comparison.shift
    poor = beyond_noise(comparison.input, comparison.overall)
    if shift is None or not {"motor_position", "output_position"} & {*poor}:
        return ""
    both = ", and both encoders show it" if shift.by_both else ""
    return (
        f"The position error grows in proportion to the speed{both}: most likely the machine follows its setpoint "
        f"{shift_words(shift)} than the twin, such as by when in a cycle the drive reads and traces its "
        "signals. Such a shift is no missing effect: it does not change the torque that a motion needs."
    )


def shift_words(shift: SetpointShift) -> str:
    """``679 µs (0.7 of a sample) earlier``."""
    when = "earlier" if shift.seconds > 0.0 else "later"
    samples = f"{shift.samples:.1f} {'of a sample' if shift.samples < 1.0 else 'samples'}"
    return f"{quantity(abs(shift.seconds), 's', 2)} ({samples}) {when}"

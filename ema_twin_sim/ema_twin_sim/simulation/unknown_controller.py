"""Models of which no speed controller is known: only a recorded current or torque can drive them.

Their current is interpolated between samples, and nothing is computed more often. So a slow log needs no thousands of
steps a sample, unless a torque repeats with an angle, which may turn far within a sample.
"""

from __future__ import annotations

from ..effects import catalogue
from ..model import Model
from ..model.constants import CONSTANTS
from ..model.model_file import ABSENT

CONTROL_CYCLE = "drive.control_cycle"
CYCLES_IN_SAMPLE = 8
"""Control cycles assumed in a sample period: as many as usual ones in a period of 1 ms."""


def without_controller(model: Model) -> bool:
    """Whether nothing is known of a speed controller."""
    return all(model.constants[path].source == ABSENT for path in ("drive.speed_gain", CONTROL_CYCLE))


def control_cycle(model: Model) -> float:
    """The control cycle [s] in which a model is simulated: its own, or where it has none a share of a slow sample."""
    usual = model.value(CONTROL_CYCLE)
    if not without_controller(model):
        return usual
    return max(min(model.value("sensors.sample_period") / CYCLES_IN_SAMPLE, CONSTANTS[CONTROL_CYCLE].upper), usual)


def stepped_cycle(model: Model) -> float:
    """The control cycle [s] of which a step is a share: the usual one, however slow the samples, if torques repeat."""
    return model.value(CONTROL_CYCLE) if _repeats(model) else control_cycle(model)


def _repeats(model: Model) -> bool:
    """Whether a torque of the model repeats with an angle, by an order: gravity does once per turn of the output."""
    over = [(catalogue()[held.effect].depends_on, "order" in held.options) for held in model.active.values()]
    return any(quantity == "order" or (by_order and quantity != "encoders") for quantity, by_order in over)

"""A stiff drive for a model that has none, so that a planned command can be simulated before it is recorded."""

from __future__ import annotations

from ..model import Model
from .simulate import has_speed_controller

QUICKER = 0.1
"""Bandwidth of the speed loop relative to the sample rate, and of the position loop relative to the speed loop."""


def with_stand_in_drive(model: Model) -> Model:
    """The model, with a speed and a position controller added if its drive has no gains."""
    if has_speed_controller(model):
        return model
    inertia = sum(model.value(f"machine.{part}_inertia") for part in ("motor", "gearbox", "output"))
    bandwidth = QUICKER / model.value("sensors.sample_period")  # rad/s
    for path, value in (
        ("drive.speed_gain", inertia * bandwidth),
        ("drive.integral_time", 1.0 / (QUICKER * bandwidth)),
        ("drive.integral_limit", model.value("drive.torque_limit")),
        ("drive.position_gain", QUICKER * bandwidth * model.value("machine.gear_ratio")),
    ):
        model = model.with_value(path, value)
    return model

"""The effects that estimation relies on, found by trait: a machine's own friction, backlash and compliance, sensors."""

from __future__ import annotations

from ..effects import Trait, the_effect

DRY_FRICTION = the_effect(Trait.DRY_FRICTION)
VISCOUS_FRICTION = the_effect(Trait.VISCOUS_FRICTION)
FRICTION = (VISCOUS_FRICTION, DRY_FRICTION)
"""Frictions that a model may know within a tolerance, like its inertia."""
PLAY = the_effect(Trait.PLAY)
SPRING = the_effect(Trait.SPRING)
COMPLIANT_EFFECTS = (PLAY, SPRING)
"""Effects that let the two encoders differ."""
SENSOR_DELAY = the_effect(Trait.SENSOR_DELAY)
SENSOR_WAVE = the_effect(Trait.SENSOR_WAVE)
TORQUE_FACTOR = the_effect(Trait.TORQUE_FACTOR)
BRISTLE = the_effect(Trait.BRISTLE)

"""The effects that estimation is built on, by their traits: a machine's own friction, play and spring, sensors."""

from __future__ import annotations

from ..effects import Trait, the_effect

DRY_FRICTION = the_effect(Trait.DRY_FRICTION)
VISCOUS_FRICTION = the_effect(Trait.VISCOUS_FRICTION)
FRICTION = (VISCOUS_FRICTION, DRY_FRICTION)
"""What a model may know within a tolerance, as it knows its inertia."""
PLAY = the_effect(Trait.PLAY)
SPRING = the_effect(Trait.SPRING)
COMPLIANT_EFFECTS = (PLAY, SPRING)
"""What lets the two encoders part."""
SENSOR_DELAY = the_effect(Trait.SENSOR_DELAY)
SENSOR_WAVE = the_effect(Trait.SENSOR_WAVE)
TORQUE_FACTOR = the_effect(Trait.TORQUE_FACTOR)
BRISTLE = the_effect(Trait.BRISTLE)

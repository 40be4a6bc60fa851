"""Traits: what rules need to know about an effect in addition to its equation, so that no rule names an effect."""

from __future__ import annotations

from enum import Enum, auto


class Trait(Enum):
    """A property of an effect, set in the effect's file and used by rules."""

    DRY_FRICTION = auto()
    """The machine's own constant friction: ``torque`` on a ``side``, known within a tolerance."""
    VISCOUS_FRICTION = auto()
    """The machine's own friction proportional to speed: ``coefficient`` on a ``side``, known within a tolerance."""
    PLAY = auto()
    """A gap of some ``width`` between motor and output, so that the two encoders may differ."""
    SPRING = auto()
    """A ``stiffness`` and ``damping`` between motor and output, so that the two encoders may differ."""
    ABOVE_DRY_FRICTION = auto()
    """Friction in excess of the constant dry friction: a machine without that one does not have it."""
    ACTS_AT_REVERSALS = auto()
    """A law by which dry friction reverses, over a travel, a range of speeds, or both: not visible elsewhere."""
    SCALES_DRY_FRICTION = auto()
    """A factor on the whole level of dry friction, whatever the level consists of."""
    BRISTLE = auto()
    """Friction that starts as a spring: visible at the start of a motion, and near standstill."""
    FRICTION_UNDER_LOAD = auto()
    """Friction proportional to the transmitted load; under a constant load it looks like constant friction."""
    TORQUE_FACTOR = auto()
    """One factor, ``scale``, on all torques: no motion distinguishes it from all constants being off by one factor."""
    SENSOR_DELAY = auto()
    """An output encoder delayed by ``delay``."""
    SENSOR_WAVE = auto()
    """An output encoder error with ``amplitude`` and ``phase`` over the output angle."""
    MOTOR_WAVE = auto()
    """A torque of any ``order`` per motor turn."""
    OUTPUT_WAVE = auto()
    """A torque of any ``order`` per output turn."""
    GEAR_WAVE = auto()
    """A torque of any ``order`` caused by a gear between the two shafts."""

    LOAD = auto()
    """A torque on the output that the model knows in advance, independent of motion."""
    OF_TEETH = auto()
    """Caused by gear teeth: impossible if the output turns with the motor."""
    OF_OUTPUT_TURNS = auto()
    """Depends on turns of the output: impossible for a carriage."""
    LIKE_A_CONSTANT = auto()
    """Acts like one of the machine's constants, and may be mistaken for an error of that constant."""
    LIKE_PLAY_OR_SPRING = auto()
    """A gearbox that rings or bounces looks like this in the torque alone."""
    SHOWN_BY_REVERSALS = auto()
    """Without reversals it looks like a small friction error."""

    WOUND_UP = auto()
    """Grows with the travel since the start, without limit: a shaft that turns on and on cannot have it."""
    NOT_AT_REST = auto()
    """Not visible at rest."""
    TRANSIENT = auto()
    """Not visible at operating points: it needs acceleration, travel or time."""
    BY_CURRENT = auto()
    """Proportional to the current that is to be explained: at operating points it would explain any current."""

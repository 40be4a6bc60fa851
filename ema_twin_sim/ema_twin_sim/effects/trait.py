"""Traits: what rules need to know of an effect beside its equation, so that no rule names one."""

from __future__ import annotations

from enum import Enum, auto


class Trait(Enum):
    """One thing that is true of an effect, said in the effect's file and asked for by rules."""

    DRY_FRICTION = auto()
    """The machine's own constant friction: ``torque`` on a ``side``, known within a tolerance."""
    VISCOUS_FRICTION = auto()
    """The machine's own friction in proportion to speed: ``coefficient`` on a ``side``, known within a tolerance."""
    PLAY = auto()
    """A gap of some ``width`` between motor and output, which lets the two encoders part."""
    SPRING = auto()
    """A ``stiffness`` and ``damping`` between motor and output, which let the two encoders part."""
    BRISTLE = auto()
    """Friction that begins as a spring: it shows in the first moments of a motion, and near standstill."""
    FRICTION_UNDER_LOAD = auto()
    """Friction in proportion to the load that is passed on; without loads that vary it looks like constant friction."""
    TORQUE_FACTOR = auto()
    """One factor, ``scale``, on all torques at once: no motion tells it from every constant being off alike."""
    SENSOR_DELAY = auto()
    """An output encoder that is late by ``delay``."""
    SENSOR_WAVE = auto()
    """An output encoder's error of ``amplitude`` and ``phase`` over the output's angle."""
    MOTOR_WAVE = auto()
    """A torque of any ``order`` in the motor's turns."""
    OUTPUT_WAVE = auto()
    """A torque of any ``order`` in the output's turns."""
    GEAR_WAVE = auto()
    """A torque of any ``order`` that a gear between the two shafts brings about."""

    LOAD = auto()
    """Torque on the output that a model knows beforehand, whatever moves."""
    OF_TEETH = auto()
    """Of the teeth of gears: where the motor turns as its output does, there are none."""
    OF_OUTPUT_TURNS = auto()
    """Over the output's turns: a carriage makes none."""
    LIKE_A_CONSTANT = auto()
    """Acts as one of the machine's constants does, and may stand behind that one being off."""
    LIKE_PLAY_OR_SPRING = auto()
    """What a gearbox that rings or bounces looks like in the torque alone."""
    SHOWN_BY_REVERSALS = auto()
    """Where nothing reverses, it looks like friction that is off by a little."""

    NOT_AT_REST = auto()
    """Does not show where nothing turns."""
    TRANSIENT = auto()
    """No operating point shows it: it takes an acceleration, a way or a time."""
    BY_CURRENT = auto()
    """In proportion to the very current that is to be explained: at operating points it would explain any."""

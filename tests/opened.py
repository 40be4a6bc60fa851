"""Models of machines of which something is not known."""

import math
from dataclasses import replace


def an_open(model):
    """The model with an open inertia."""
    inertia = replace(model.constants["machine.motor_inertia"], tolerance=math.inf)
    return replace(model, constants={**model.constants, "machine.motor_inertia": inertia})


def with_open_effects(model):
    """The model with open friction, and whatever effects it has."""
    return replace(model, effects={name: replace(held, open=True) for name, held in model.effects.items()})


def all_open(model):
    """Both."""
    return an_open(with_open_effects(model))

"""The catalogue of effects: one file per effect."""

from .catalogue import catalogue, effects_with, find_effect, the_effect
from .effect import Circumstances, Effect, Parameter, Trait

__all__ = ["Circumstances", "Effect", "Parameter", "Trait", "catalogue", "effects_with", "find_effect", "the_effect"]

"""The catalogue of effects: one file an effect."""

from .catalogue import catalogue, find_effect
from .effect import Effect, Parameter

__all__ = ["Effect", "Parameter", "catalogue", "find_effect"]

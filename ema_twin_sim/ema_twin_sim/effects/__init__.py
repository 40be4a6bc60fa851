"""The catalogue of effects: one file an effect."""

from .catalogue import catalogue, find_effect
from .effect import Circumstances, Effect, Parameter

__all__ = ["Circumstances", "Effect", "Parameter", "catalogue", "find_effect"]

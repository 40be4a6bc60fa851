"""The catalogue of effects: one file per effect."""

from .catalogue import catalogue, effects_with, find_effect, the_effect
from .effect import NOTHING_KNOWN, Circumstances, Effect, Parameter, Trait

__all__ = [
    "NOTHING_KNOWN",
    "Circumstances",
    "Effect",
    "Parameter",
    "Trait",
    "catalogue",
    "effects_with",
    "find_effect",
    "the_effect",
]

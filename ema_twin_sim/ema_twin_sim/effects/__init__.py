"""The catalogue of effects: one file per effect."""

from .catalogue import Kind, catalogue, effects_with, find_effect, kind_of, the_effect
from .effect import NOTHING_KNOWN, Circumstances, Effect, Parameter, Trait

__all__ = [
    "NOTHING_KNOWN",
    "Circumstances",
    "Effect",
    "Kind",
    "Parameter",
    "Trait",
    "catalogue",
    "effects_with",
    "find_effect",
    "kind_of",
    "the_effect",
]

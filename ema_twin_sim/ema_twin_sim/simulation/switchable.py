"""A model with all effects of the catalogue, those that it lacks switched off, so that a running twin can add them."""

from __future__ import annotations

from ..effects import catalogue
from ..model import Model

_AT_LEAST = 2
"""Minimum instances of a repeatable effect with options: mesh ripple at two orders, friction on either side."""


def switchable(model: Model) -> Model:
    """The model with a switched-off instance of each effect that it lacks, or that a machine may have several times."""
    for id, effect in catalogue().items():
        several = effect.repeatable and effect.options
        held = sum(instance.effect == id for instance in model.effects.values())
        wanted = max(_AT_LEAST, held + 1) if several else 1
        for _ in range(wanted - held):
            model = model.with_effect(id, enabled=False)
    return model

"""A model with all effects of the catalogue, switched off where it lacks them: what a running twin can be given."""

from __future__ import annotations

from ..effects import catalogue
from ..model import Model

_AT_LEAST = 2
"""Instances of an effect with options: the ripple of a mesh at two of its orders, friction on either side."""


def switchable(model: Model) -> Model:
    """The model with one spare instance of each effect that it lacks, or of which a machine may have several kinds."""
    for id, effect in catalogue().items():
        several = effect.repeatable and effect.options
        held = sum(instance.effect == id for instance in model.effects.values())
        wanted = max(_AT_LEAST, held + 1) if several else 1
        for _ in range(wanted - held):
            model = model.with_effect(id, enabled=False)
    return model

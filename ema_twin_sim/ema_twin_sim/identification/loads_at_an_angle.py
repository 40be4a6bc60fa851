"""Loads that depend on where the output stands, counted from an angle of their own: an arm, a return spring."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..effects import Effect, Parameter, Trait, catalogue, effects_with
from ..model import EffectInstance, Model
from ..model.own_units import is_linear, table_in
from ..simulation.angle_origins import acts_at_an_angle


@dataclass(frozen=True, eq=False)
class Load:
    """A load at an angle: of a size, as a sum of two torques by which its angle in each recording is free."""

    effect: Effect
    options: dict[str, str]
    angle: Parameter

    def is_of(self, instance: EffectInstance) -> bool:
        """Whether an instance is one of these."""
        return instance.effect == self.effect.id and self.options.items() <= {**instance.options}.items()

    def at(self, angle: float) -> EffectInstance:
        """The load of its usual size at an ``angle`` [rad, output]."""
        parameters = {p.name: p.default for p in self.effect.parameters_with(self.options)}
        return EffectInstance(self.effect.id, self.options, {**parameters, self.angle.name: angle})

    @property
    def two(self) -> tuple[EffectInstance, EffectInstance]:
        """The two whose sum it is at any angle."""
        return self.at(0.0), self.at(0.5 * math.pi if self.angle.periodic else 1.0)

    def shares(self, size: float, angles: np.ndarray) -> np.ndarray:
        """Shares (R, 2) of the two in loads of a ``size`` (in usual ones) at ``angles`` (R,) [rad]."""
        if self.angle.periodic:
            return size * np.stack([np.cos(angles), np.sin(angles)], 1)
        return size * np.stack([1.0 - angles, angles], 1)

    def of_shares(self, shares: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The sizes (R,) and angles (R,) of given ``shares`` (R, 2)."""
        if self.angle.periodic:
            return np.hypot(*shares.T), np.arctan2(shares[:, 1], shares[:, 0])
        sizes = shares.sum(1)
        return sizes, shares[:, 1] / np.where(sizes == 0.0, 1.0, sizes)

    def moved(self, angles: np.ndarray, to: float | np.ndarray) -> np.ndarray:
        """How far (R,) [rad, output] to move zeros so that loads at ``angles`` (R,) are at the angle ``to``."""
        if self.angle.periodic:
            return np.remainder(angles - to + math.pi, 2.0 * math.pi) - math.pi
        return to - angles


def loads_of(model: Model) -> list[str]:
    """The loads of a model that act at an angle of the output."""
    return [name for name, held in model.active.items() if is_load_at_an_angle(held)]


def is_load_at_an_angle(instance: EffectInstance) -> bool:
    """Whether an effect is such a load."""
    return instance.effect in effects_with(Trait.LOAD) and acts_at_an_angle(instance)


def loads_at_an_angle(model: Model) -> list[Load]:
    """The loads at an angle that a machine may have."""
    found = []
    for id in sorted(effects_with(Trait.LOAD)):
        effect = table_in(catalogue()[id], model.units)
        choices = effect.options[effect.law] if effect.law else ("",)
        for options in ({**effect.default_options(), **({effect.law: each} if each else {})} for each in choices):
            angle = next((p for p in effect.parameters_with(options) if p.periodic or p.is_place), None)
            if angle is not None and not (is_linear(model) and Trait.OF_OUTPUT_TURNS in effect.traits):
                found.append(Load(effect, options, angle))
    return found

"""Predictions: what a hypothesis says that recordings would show, and who can make one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ..effects import catalogue
from ..effects.catalogue import is_own
from ..effects.effect import Effect
from ..measured.observation import Observation
from ..model import EffectInstance
from ..plant.layout import DRY_LEVEL, OUTPUT_TORQUE, VISCOUS_COEFFICIENT
from ..plant.measured_motion import OUTPUT_ANGLE, TIME
from ..plant.sensors import angle_error
from .hypothesis import Hypothesis

OF_THE_MODEL = {"transmitted_torque", "dry_level", "viscous_coefficient"}
"""What of an operating point is not measured, but the model's."""


@dataclass(frozen=True, eq=False)
class Prediction:
    """What a hypothesis predicts: all rows (m,) in units of noise, and what it stands on."""

    rows: np.ndarray
    plant: np.ndarray
    required: tuple[np.ndarray, ...]
    by_load: bool  # whether something of it follows the load


class Predictor(Protocol):
    """What predicts the rows of hypotheses."""

    def predict(self, h: Hypothesis, beside: Prediction | None = None, *, side_by_side: bool = False) -> Prediction:
        """What the hypothesis predicts; of ``beside`` and ``side_by_side`` see ``EquationErrorProblem.predict``."""
        ...

    def rows_of(self, several: Sequence[Hypothesis]) -> list[np.ndarray]:
        """The rows (m,) that each of several hypotheses predicts."""
        ...


def seen_output(o: Observation, plant: np.void) -> np.ndarray:
    """Where the output was (n,) [rad], from what its encoder shows, late and off its centre as a plant has it."""
    time, shown = o.motion[:, TIME], o.motion[:, OUTPUT_ANGLE]
    if plant["angle_errors"]:  # which are small, so that it is no matter at which of both angles they are taken
        shown = shown - angle_error(plant, o.output_origin, shown)
    if plant["encoder_delay"] != 0.0:
        shown = np.interp(time + plant["encoder_delay"], time, shown)
    return np.ascontiguousarray(shown)


def follows_measured_motion(effect: Effect, place: int) -> bool:
    """Whether an effect asks for the same torque beside every model of one machine: it follows what was measured."""
    if effect.act is None or is_own(effect) or place in (DRY_LEVEL, VISCOUS_COEFFICIENT):
        return False
    return not OF_THE_MODEL & {*effect.act.__code__.co_names}  # the package's effects ask for values by their names


def acts_at_the_motor(instance: EffectInstance) -> bool:
    """Whether an effect changes what the motor's side asks for, and nothing of how an output behind play moves."""
    effect = catalogue()[instance.effect]
    return effect.act is not None and effect.where(instance.options) != OUTPUT_TORQUE

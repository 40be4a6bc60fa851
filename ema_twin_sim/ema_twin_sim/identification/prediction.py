"""Predictions: the rows that a hypothesis predicts for recordings, and the interface of predictors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from ..effects import catalogue
from ..effects.catalogue import is_own
from ..effects.effect import Effect
from ..measured.observation import Observation
from ..model import EffectInstance
from ..plant.layout import OUTPUT_TORQUE
from ..plant.measured_motion import REQUIRED_DRY
from ..plant.motion import OUTPUT_ANGLE, TIME
from ..plant.sensors import angle_error
from .hypothesis import Hypothesis

OF_THE_MODEL = {"transmitted_torque", "dry_level", "viscous_coefficient"}
"""Quantities of an operating point that come from the model and are not measured."""


@dataclass(frozen=True, eq=False)
class Prediction:
    """Prediction of a hypothesis: all rows (m,) in units of noise, and the data behind them."""

    rows: np.ndarray
    plant: np.ndarray
    required: np.ndarray  # (n, 4) at the samples of all recordings, with the columns REQUIRED
    starts: np.ndarray  # int64 (R + 1,), the samples where each recording starts and the last one ends
    by_load: bool  # whether any part follows the load
    scaled_level: bool  # whether an effect is a factor on the whole dry level

    @cached_property
    def lowest_dry_level(self) -> float:
        """The lowest dry friction level [N m] at any sample."""
        return float(self.required[:, REQUIRED_DRY].min())

    @property
    def required_by_recording(self) -> list[np.ndarray]:
        """``required`` of each recording."""
        return np.split(self.required, self.starts[1:-1])


class Predictor(Protocol):
    """Anything that predicts the rows of hypotheses."""

    def predict(self, h: Hypothesis, beside: Prediction | None = None, *, side_by_side: bool = False) -> Prediction:
        """Predict the rows of a hypothesis; for the arguments see ``EquationErrorProblem.predict``."""
        ...

    def rows_of(self, several: Sequence[Hypothesis]) -> list[np.ndarray]:
        """The predicted rows (m,) of several hypotheses."""
        ...


def seen_output(o: Observation, plant: np.void) -> np.ndarray:
    """Output position (n,) [rad] from its encoder reading, corrected for the plant's encoder delay and eccentricity."""
    time, shown = o.motion[:, TIME], o.motion[:, OUTPUT_ANGLE]
    if plant["angle_errors"]:  # these are small, so either angle may be used to compute them
        shown = shown - angle_error(plant, o.output_origin, shown)
    if plant["encoder_delay"] != 0.0:
        shown = np.interp(time + plant["encoder_delay"], time, shown)
    return np.ascontiguousarray(shown)


def follows_measured_motion(effect: Effect) -> bool:
    """Whether an effect has the same value in every model of a machine: it depends on measured values only."""
    if effect.act is None or is_own(effect):
        return False
    return not OF_THE_MODEL & {*effect.act.__code__.co_names}  # the package's effects request values by name


def acts_at_the_motor(instance: EffectInstance) -> bool:
    """Whether an effect changes only the motor side and not the motion of an output with backlash or compliance."""
    effect = catalogue()[instance.effect]
    return effect.act is not None and effect.where(instance.options) != OUTPUT_TORQUE

"""Equation error of a hypothesis over all recordings: measured torque minus the torque that the motion requires."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..effects import catalogue
from ..measured.observation import Observation
from ..measured.smoothing import smooth_at
from ..model import EffectInstance
from ..parallel import predictions
from ..plant.layout import DRY_LEVEL, OUTPUT_TORQUE
from ..plant.measured_motion import MOTOR_ANGLE, REQUIRED, TIME, inverse_dynamics, inverse_dynamics_of
from ..plant.sensors import as_encoder_shows
from ..simulation.assembly import assemble, effect_address, effect_slots, longest_delay
from .hypothesis import Hypothesis
from .prediction import Prediction, acts_at_the_motor, follows_measured_motion, seen_output
from .search_limits import search_limits
from .wander import Wander
from .weighted_rows import WeightedRows
from .weighting import Weighting

NOWHERE = np.empty(0)
KEPT = 200_000_000  # bytes at most for rows that are the same for every hypothesis


@dataclass(frozen=True, eq=False, init=False)
class EquationErrorProblem(WeightedRows):
    """What a fit minimises: recordings under one weighting, and the generic bases that a hypothesis may have.

    It is frozen. Another weighting makes another problem (``under``), and misfits to the two do not compare.
    """

    generic_bases: Mapping[str, np.ndarray]  # columns (m, k) by name, in units of the total noise
    kept_rows: dict[tuple[object, ...], np.ndarray]  # (s, k), of effects whose torque is the same in any model
    kept_bases: dict[Wander | None, Mapping[str, np.ndarray]]  # generic bases under this wander

    def __init__(self, observations: Sequence[Observation]) -> None:
        super().__init__(observations)
        vars(self).update(generic_bases={}, kept_rows={}, kept_bases={})

    def under(self, weighting: Weighting) -> EquationErrorProblem:
        """The same recordings under another weighting; generic bases in units of another noise are dropped."""
        other = super().under(weighting)
        return other if weighting.wander is self.weighting.wander else other.with_generic_bases({})

    def with_generic_bases(self, bases: Mapping[str, np.ndarray]) -> EquationErrorProblem:
        """The same problem with these generic bases, columns (m, k) by name, instead of its own."""
        return self._but(generic_bases=bases)

    def with_motor_zeros_off(self, angle: float) -> EquationErrorProblem:
        """The same problem with all zeros of the motor counters shifted by an angle [rad]."""
        turned = tuple(replace(o, motor_origin=o.motor_origin + angle) for o in self.observations)
        return self._but(observations=turned, kept_rows={}, kept_bases={})

    def bounds(self, h: Hypothesis) -> tuple[np.ndarray, np.ndarray]:
        """(lower, upper) (k,) of the free parameters; those of effects limited to what these recordings reach."""
        lower = np.array([free.lower for free in h.free])
        upper = np.array([free.upper for free in h.free])
        for k, free in enumerate(h.free):
            p = h.parameter_of(free.path)
            if p is None:
                continue
            effect = catalogue()[h.added[free.path.split(".")[1]].effect]
            least, most = search_limits(effect, p, self.reached)
            if not p.periodic:
                lower[k] = max(lower[k], least)
                upper[k] = max(min(upper[k], most), lower[k])
            if effect.delays:  # limited to the history of encoder readings that the plant keeps
                upper[k] = max(min(upper[k], longest_delay(h.base)), lower[k])
            if p.driven:  # a speed that only matters within the driven range
                upper[k] = max(min(upper[k], self.fastest), lower[k])
        return lower, upper

    def predict(self, h: Hypothesis, beside: Prediction | None = None, *, side_by_side: bool = False) -> Prediction:
        """Predict the rows of a hypothesis; recordings run ``side_by_side`` (in parallel) if nothing else does.

        If a prediction ``beside`` is given, the output moves as it does there: only the motor side differs.
        """
        assembly = assemble(h.model())
        plant = assembly.plant[0]
        rigid = plant["two_inertia"] == 0.0
        rows = np.zeros(self.rows)

        def one(o: Observation, t: slice, e: slice, known: np.ndarray | None) -> np.ndarray:
            of = (assembly.plant, assembly.effects, o.motion, o.motor_origin, o.output_origin)
            required = np.empty((len(o.motion), len(REQUIRED))) if known is None else known.copy()
            seen = seen_output(o, plant) if plant["gap"] > 0.0 and len(o.encoder_rows) else NOWHERE
            inverse_dynamics(*of, seen, known is not None, required)
            smooth_at(np.ascontiguousarray(required[:, 0]), o.kernel, o.rows, rows[t])
            if len(o.encoder_rows):
                shown = required[:, 1]
                difference = o.motion[:, MOTOR_ANGLE] / plant["gear_ratio"]
                if rigid and plant["encoder_delay"] == 0.0 and not plant["angle_errors"]:
                    return required
                shown = as_encoder_shows(plant, o.motion[:, TIME], shown, o.output_origin)
                smooth_at(shown - difference, o.kernel, o.encoder_rows, rows[e])
            return required

        known = [None] * len(self.observations) if beside is None else beside.required
        parts = (self.observations, self.torque_parts, self.encoder_parts, known)
        every = list(predictions(self.samples if side_by_side else 0, one, *parts))
        rows = self._in_noise(h, plant, rows)
        by_load = any(catalogue()[id].depends_on == "load" for id in h.held)
        return Prediction(rows, assembly.plant, tuple(every), by_load)

    def _in_noise(self, h: Hypothesis, plant: np.void, rows: np.ndarray) -> np.ndarray:
        """Rows (m,) in units of noise, from required torque [N m] and encoder difference [rad]."""
        inertia = plant["motor_inertia"] + (plant["output_inertia"] if plant["two_inertia"] == 0.0 else 0.0)
        torque = (rows[: self.size] + inertia * self.acceleration) / torque_scale(plant) + h.lag() * self.rate
        rows[: self.size] = torque / self.noise
        rows[self.size :] /= self.encoder_noise
        rows = self.whitened(rows)
        for name in h.generic_bases:
            start = f"basis.{name}."
            rows += self.generic_bases[name] @ [
                v for f, v in zip(h.free, h.values, strict=True) if f.path.startswith(start)
            ]
        return rows

    def rows_of(self, several: Sequence[Hypothesis]) -> list[np.ndarray]:
        """Predicted rows (m,) of several hypotheses; those with backlash or compliance are simulated together."""
        from .side_by_side import groups, simulate  # imported here, since machines without backlash need not load it

        assemblies = [assemble(h.model()) for h in several]
        together = groups(assemblies)
        rows = {k: np.zeros(self.rows) for group in together for k in group}
        jobs = [
            ([(assemblies[k], rows[k]) for k in group], *of)
            for group in together
            for of in zip(self.observations, self.torque_parts, self.encoder_parts, strict=True)
        ]
        for _ in predictions(self.samples, lambda job: simulate(*job), jobs):
            pass
        return [
            self._in_noise(h, assemblies[k].plant[0], rows[k]) if k in rows else self.predict(h).rows
            for k, h in enumerate(several)
        ]

    def alone(self, beside: Prediction, instance: EffectInstance) -> np.ndarray | None:
        """Rows (m,) that one effect adds to a prediction, without a new simulation; None if that is not possible."""
        if not _acts_alone(beside, instance):
            return None
        rows = np.zeros(self.rows)
        rows[: self.size] = self._required_by(beside, instance) / (torque_scale(beside.plant[0]) * self.noise)
        return self.whitened(rows)

    def alike_beside_any(self, beside: Prediction, instances: Sequence[EffectInstance]) -> np.ndarray | None:
        """Torque rows (s, k) that several ``instances`` of one effect add to any prediction for this machine.

        None if the effect's torque depends on the model. The rows are cached as far as memory allows, because a search
        needs them repeatedly.
        """
        first = instances[0]
        effect = catalogue()[first.effect]
        if effect.act is None or not follows_measured_motion(effect, effect.where(first.options)):
            return None
        if not _acts_alone(beside, first):
            return None
        plant = beside.plant[0]
        constants = (plant[name].item() for name in ("gear_ratio", "pole_pairs", "torque_constant"))
        slots = (tuple(effect_slots(effect, one)) for one in instances)
        key = (effect_address(effect), effect.where(first.options), self.weighting.wander, *constants, *slots)
        rows = self.kept_rows.get(key)
        if rows is None:
            rows = np.zeros((self.rows, len(instances)))
            rows[: self.size] = np.stack([self._required_by(beside, one) / self.noise for one in instances], 1)
            rows = self.whitened(rows)[: self.size]
            kept = list(self.kept_rows.values())  # a copy: other threads may add theirs meanwhile
            if sum(one.nbytes for one in kept) + rows.nbytes < KEPT:
                self.kept_rows[key] = rows
        return rows / torque_scale(plant)

    def _required_by(self, beside: Prediction, instance: EffectInstance) -> np.ndarray:
        """Torque (s,) [N m] that one effect alone requires of the drive, smoothed like the measured torque."""
        effect = catalogue()[instance.effect]
        address, place = effect_address(effect), effect.where(instance.options)
        slots = np.array(effect_slots(effect, instance))
        smoothed = np.zeros(self.size)
        for o, t, required in zip(self.observations, self.torque_parts, beside.required, strict=True):
            torque = np.empty(len(o.motion))
            of = (o.motion, o.motor_origin, o.output_origin, required, torque)
            inverse_dynamics_of(beside.plant, address, place, slots, *of)
            smooth_at(torque, o.kernel, o.rows, smoothed[t])
        return smoothed

    def beside(self, h: Hypothesis, predicted: Prediction, instance: EffectInstance) -> np.ndarray | None:
        """Rows (m,) that one more effect adds to a prediction with the output motion unchanged; None if it changes."""
        rows = self.alone(predicted, instance)
        if rows is None and predicted.plant["two_inertia"][0] != 0.0 and acts_at_the_motor(instance):
            more = h.with_effect(instance.effect, instance.options, instance.parameters)
            rows = self.predict(more, beside=predicted).rows - predicted.rows
        return rows

    def residual(self, predicted: Prediction) -> np.ndarray:
        """Measured minus predicted (m,), in units of noise, with the encoder offsets removed robustly."""
        return self.unexplained(predicted.rows)

    def left_over(self, predicted: Prediction) -> np.ndarray:
        """Residual (m,) of the measured signals in units of the sensors' noise, wandering friction included."""
        rows = self.residual(predicted)
        return rows if self.weighting.wander is None else self.weighting.wander.as_measured(rows)


def torque_scale(plant: np.void) -> float:
    """Torque per current, relative to the model file's."""
    return float(plant["torque_constant"] / plant["nominal_torque_constant"])


def _acts_alone(beside: Prediction, instance: EffectInstance) -> bool:
    """Whether an effect only adds its own torque to a prediction and changes nothing else."""
    effect = catalogue()[instance.effect]
    plant = beside.plant[0]
    if effect.settle is not None:
        return False
    place = effect.where(instance.options)
    if place == DRY_LEVEL and plant["bristle_stiffness"] > 0.0:
        return False
    return not (place == OUTPUT_TORQUE and (plant["two_inertia"] != 0.0 or beside.by_load))

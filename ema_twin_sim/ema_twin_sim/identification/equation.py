"""Equation error of a hypothesis over all recordings: measured torque minus the torque that the motion requires."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..effects import Trait, catalogue, effects_with
from ..measured.observation import Observation
from ..measured.smoothing import smooth_at
from ..model import EffectInstance
from ..model.own_units import table_in
from ..parallel import predictions
from ..plant.layout import DRY_LEVEL, OUTPUT_TORQUE, VISCOUS_COEFFICIENT
from ..plant.measured_motion import REQUIRED, REQUIRED_OUTPUT
from ..plant.motion import MOTOR_ANGLE, TIME
from ..plant.sensors import as_encoder_shows
from ..simulation.assembly import assemble, effect_address, effect_slots, longest_delay
from .hypothesis import Hypothesis
from .prediction import Prediction, acts_at_the_motor, follows_measured_motion, seen_output
from .search_limits import search_limits
from .wander import Wander
from .weighted_rows import WeightedRows
from .weighting import Weighting

KEPT = 200_000_000  # bytes at most for rows that are the same for every hypothesis


@dataclass(frozen=True, eq=False)
class AlikeRows:
    """Torque rows (s, k) of instances of one effect, the same beside every prediction with a friction level as high."""

    rows: np.ndarray
    needed_level: float  # N m, of dry friction


@dataclass(frozen=True, eq=False, init=False)
class EquationErrorProblem(WeightedRows):
    """What a fit minimises: recordings under one weighting, and the generic bases that a hypothesis may have.

    It is frozen. Another weighting makes another problem (``under``), and misfits to the two do not compare.
    """

    generic_bases: Mapping[str, np.ndarray]  # columns (m, k) by name, in units of the total noise
    kept_rows: dict[tuple[object, ...], AlikeRows]  # of effects whose torque is the same in any model
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

    def with_encoders_late_by(self, seconds: float) -> EquationErrorProblem:
        """The same problem with delays of an encoder of up to so many ``seconds``."""
        return self._but(reached=replace(self.reached, latest=seconds))

    def bounds(self, h: Hypothesis) -> tuple[np.ndarray, np.ndarray]:
        """(lower, upper) (k,) of the free parameters; those of effects limited to what these recordings reach."""
        lower = np.array([free.lower for free in h.free])
        upper = np.array([free.upper for free in h.free])
        for k, free in enumerate(h.free):
            p = h.parameter_of(free.path)
            if p is None:
                continue
            effect = table_in(catalogue()[h.added[free.path.split(".")[1]].effect], h.base.units)
            least, most = search_limits(effect, p, self.reached)
            if not p.periodic:
                lower[k] = max(lower[k], least)
                upper[k] = max(min(upper[k], most), lower[k])
            if effect.delays:  # limited to the history of encoder readings that the plant keeps
                upper[k] = max(min(upper[k], longest_delay(h.base)), lower[k])
            if p.driven:  # a speed that only matters within the driven range
                upper[k] = max(min(upper[k], p.driven * self.fastest), lower[k])
        return lower, upper

    def predict(self, h: Hypothesis, beside: Prediction | None = None, *, side_by_side: bool = False) -> Prediction:
        """Predict the rows of a hypothesis; ``side_by_side``: in two threads, if nothing else runs.

        If a prediction ``beside`` is given, the output moves as it does there: only the motor side differs.
        """
        assembly = assemble(h.model())
        plant = assembly.plant[0]
        seen, has_seen = self._seen_outputs(plant)
        required = np.empty((self.samples, len(REQUIRED))) if beside is None else beside.required.copy()
        rows = np.zeros(self.rows)
        of = (assembly.plant, assembly.effects, self._origins(), seen, has_seen, beside is not None, required, rows)
        if side_by_side:
            halves = predictions(self.samples, lambda half: self.joined.require(half, *of), self.joined.halves)
            list(halves)
        else:
            self.joined.require((0, len(self.observations)), *of)
        if plant["two_inertia"] != 0.0 or plant["encoder_delay"] != 0.0 or plant["angle_errors"]:
            for k, (o, part) in enumerate(zip(self.observations, self.encoder_parts, strict=True)):
                if len(o.encoder_rows):
                    shown = required[self.joined.part(k), REQUIRED_OUTPUT]
                    shown = as_encoder_shows(plant, o.motion[:, TIME], shown, o.output_origin)
                    difference = o.motion[:, MOTOR_ANGLE] / plant["gear_ratio"]
                    smooth_at(shown - difference, o.kernel, o.encoder_rows, rows[part])
        rows = self._in_noise(h, plant, rows)
        by_load = any(catalogue()[id].depends_on == "load" for id in h.held)
        scaled_level = not h.held.isdisjoint(effects_with(Trait.SCALES_DRY_FRICTION))
        return Prediction(rows, assembly.plant, required, self.joined.starts, by_load, scaled_level)

    def _origins(self) -> np.ndarray:
        """(R, 2) [rad] readings of motor and output counter at position zero, by recording."""
        return np.array([(o.motor_origin, o.output_origin) for o in self.observations], np.float64)

    def _seen_outputs(self, plant: np.void) -> tuple[np.ndarray, np.ndarray]:
        """Measured output position (n,) [rad] behind teeth with play, and which recordings (R,) have it."""
        has_seen = np.array([plant["gap"] > 0.0 and len(o.encoder_rows) > 0 for o in self.observations])
        seen = np.empty(self.samples if has_seen.any() else 0)
        for k in map(int, np.flatnonzero(has_seen)):
            seen[self.joined.part(k)] = seen_output(self.observations[k], plant)
        return seen, has_seen

    def _in_noise(self, h: Hypothesis, plant: np.void, rows: np.ndarray) -> np.ndarray:
        """Rows (m,) in units of noise, from required torque [N m] and encoder difference [rad]."""
        rigid = plant["two_inertia"] == 0.0  # otherwise the output, and its inertia, is simulated
        inertia = plant["motor_inertia"] + (plant["output_inertia"] if rigid else 0.0)
        # In all rigid hypotheses the model's inertia acts on the rest, since its noise would choose the smallest. What
        # springs and impacts do to the motor is too quick for a wide kernel.
        acceleration = self.acceleration if rigid else self.acceleration + self.acceleration_rest
        torque = (rows[: self.size] + inertia * acceleration) / torque_scale(plant) + h.lag() * self.rate
        torque += self.rest_torque if rigid else 0.0
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
        rows[: self.size] = self._required_by(beside, instance)[0] / (torque_scale(beside.plant[0]) * self.noise)
        return self.whitened(rows)

    def alike_beside_any(self, beside: Prediction, instances: Sequence[EffectInstance]) -> np.ndarray | None:
        """Torque rows (s, k) that several ``instances`` of one effect add to any prediction for this machine.

        They hold for the model file's torque constant; divide by ``torque_scale`` for another. None if the effect's
        torque depends on the model, or if its dry friction is too low for the effect. The rows are cached as far as
        memory allows: a search needs them repeatedly.
        """
        first = instances[0]
        effect = catalogue()[first.effect]
        if effect.act is None or not follows_measured_motion(effect) or not _acts_alone(beside, first):
            return None
        plant = beside.plant[0]
        place = effect.where(first.options)
        constants = [plant[name].item() for name in ("gear_ratio", "pole_pairs", "torque_constant")]
        if place in (DRY_LEVEL, VISCOUS_COEFFICIENT):
            constants.append(plant["asymmetry"].item())
        slots = (tuple(effect_slots(effect, one)) for one in instances)
        key = (effect_address(effect), place, self.weighting.wander, *constants, *slots)
        alike = self.kept_rows.get(key)
        if alike is None:
            every = [self._required_by(beside, one) for one in instances]
            needed_level = max(-least for _, least in every) if place == DRY_LEVEL else 0.0
            if needed_level > beside.lowest_dry_level:  # the reduced level is cut off at zero: not alike
                return None
            rows = np.zeros((self.rows, len(instances)))
            rows[: self.size] = np.stack([torque / self.noise for torque, _ in every], 1)
            alike = AlikeRows(self.whitened(rows)[: self.size], needed_level)
            kept = list(self.kept_rows.values())  # a copy: other threads may add theirs meanwhile
            if sum(one.rows.nbytes for one in kept) + alike.rows.nbytes < KEPT:
                self.kept_rows[key] = alike
        return alike.rows if alike.needed_level <= beside.lowest_dry_level else None

    def _required_by(self, beside: Prediction, instance: EffectInstance) -> tuple[np.ndarray, float]:
        """Torque (s,) [N m] that one effect alone requires of the drive, smoothed like the measured torque.

        The second value is the smallest value of the effect at any sample.
        """
        effect = catalogue()[instance.effect]
        address, place = effect_address(effect), effect.where(instance.options)
        slots = np.array(effect_slots(effect, instance))
        smoothed = np.empty(self.size)
        of = (slots, self._origins(), beside.required, smoothed)
        return smoothed, self.joined.require_of(beside.plant, address, place, *of)

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
    scales = Trait.SCALES_DRY_FRICTION in effect.traits
    if place == DRY_LEVEL and (plant["bristle_stiffness"] > 0.0 or scales or beside.scaled_level):
        return False
    return not (place == OUTPUT_TORQUE and (plant["two_inertia"] != 0.0 or beside.by_load))

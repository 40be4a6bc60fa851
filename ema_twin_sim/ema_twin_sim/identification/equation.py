"""The equation error of a hypothesis over all recordings, and its slopes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from ..criteria import MISSHAPEN, NEARLY_ALL, OUTLIER, SMALL
from ..effects import catalogue
from ..effects.catalogue import is_own
from ..effects.effect import Effect
from ..measured.observation import Observation
from ..measured.smoothing import smooth_at
from ..model import EffectInstance
from ..plant.layout import DRY_LEVEL, OUTPUT_TORQUE, VISCOUS_COEFFICIENT
from ..plant.measured_motion import (
    MOTOR_ANGLE,
    OUTPUT_ANGLE,
    REQUIRED,
    SPEED,
    TIME,
    inverse_dynamics,
    inverse_dynamics_of,
)
from ..plant.sensors import angle_error, as_encoder_shows
from ..simulation.assembly import assemble, effect_address, effect_slots, longest_delay
from .hypothesis import LAG, Free, Hypothesis
from .parallel import predictions
from .search_limits import reached, search_limits
from .weighting import Weighting

NOWHERE = np.empty(0)
AT_THE_MOTOR = ("scale.inertia", "scale.coulomb_friction")  # beside numbers of the output's own
FAR = 1e9  # noise standard deviations that no row is away: least squares
INFLATED = 0.2  # share by which a variance moves before all is fitted again
OF_THE_MODEL = {"transmitted_torque", "dry_level", "viscous_coefficient"}
"""What of an operating point is not measured, but the model's."""
KEPT = 200_000_000  # bytes at most of torques that are the same beside every hypothesis


@dataclass(frozen=True, eq=False)
class Prediction:
    """What a hypothesis predicts: all rows (m,) in units of noise, and what it stands on."""

    rows: np.ndarray
    plant: np.ndarray
    required: tuple[np.ndarray, ...]
    by_load: bool  # whether something of it follows the load


def seen_output(o: Observation, plant: np.void) -> np.ndarray:
    """Where the output was (n,) [rad], from what its encoder shows, late and off its centre as a plant has it."""
    time, shown = o.motion[:, TIME], o.motion[:, OUTPUT_ANGLE]
    if plant["angle_errors"]:  # which are small, so that it is no matter at which of both angles they are taken
        shown = shown - angle_error(plant, o.output_origin, shown)
    if plant["encoder_delay"] != 0.0:
        shown = np.interp(time + plant["encoder_delay"], time, shown)
    return np.ascontiguousarray(shown)


class EquationErrorProblem:
    """Rows of several recordings: torque rows of all, then encoder rows of all, each in units of its noise."""

    def __init__(self, observations: Sequence[Observation]) -> None:
        self.observations = tuple(observations)
        self.torque = np.concatenate([o.torque for o in observations])
        self.noise = np.concatenate([o.torque_noise for o in observations])
        self.acceleration = np.concatenate([o.acceleration for o in observations])
        self.rate = np.concatenate([o.torque_rate for o in observations])
        self.encoder = np.concatenate([o.encoder for o in observations])
        self.encoder_noise = np.concatenate([o.encoder_noise for o in observations])
        self.samples = sum(len(o.motion) for o in observations)
        edges = np.cumsum([0, *(len(o.rows) for o in observations)])
        self.torque_parts = [slice(a, b) for a, b in pairwise(edges)]
        self.size = int(edges[-1])
        edges = self.size + np.cumsum([0, *(len(o.encoder_rows) for o in observations)])
        self.encoder_parts = [slice(a, b) for a, b in pairwise(edges)]
        self.encoder_pieces = [  # of a recording, between jumps of a counter
            slice(part.start + int(a), part.start + int(b))
            for o, part in zip(observations, self.encoder_parts, strict=True)
            for a, b in pairwise((0, *(np.flatnonzero(np.diff(o.encoder_piece)) + 1), len(o.encoder_piece)))
            if b > a
        ]
        self.parts = [  # (recording, rows) of all that is measured
            *enumerate(self.torque_parts),
            *((k, part) for k, part in enumerate(self.encoder_parts) if part.stop > part.start),
        ]
        self._measured = np.concatenate([self.torque / self.noise, self.encoder / self.encoder_noise])
        self.measured = self._measured  # in units of all that acts as noise
        self.rows = len(self.measured)
        speeds = np.concatenate([np.abs(o.motion[o.rows, SPEED]) for o in observations])
        self.fastest = float(np.quantile(speeds, NEARLY_ALL)) if len(speeds) else 0.0  # rad/s, of the motor
        self.outlier = OUTLIER if any(o.geared for o in observations) else MISSHAPEN
        self._weighting = Weighting.even(self.rows, FAR)
        self.generic_bases: dict[str, np.ndarray] = {}
        self.use_encoder = True
        self.reached = reached(self.observations)
        self._kept: dict[tuple[object, ...], np.ndarray] = {}

    @property
    def weighting(self) -> Weighting:
        """The weighting that fits are made under."""
        return self._weighting

    @weighting.setter
    def weighting(self, weighting: Weighting) -> None:
        if weighting.wander is not self._weighting.wander:
            self.generic_bases = {}  # which are in units of the noise
            self.measured = self._measured if weighting.wander is None else weighting.wander.whitened(self._measured)
        self._weighting = weighting

    def whitened(self, rows: np.ndarray) -> np.ndarray:
        """Rows (m,) or columns of rows (m, k), in units of the sensors' noise, in those of all that acts as noise."""
        return rows if self.weighting.wander is None else self.weighting.wander.whitened(rows)

    def bounds(self, h: Hypothesis) -> tuple[np.ndarray, np.ndarray]:
        """(lower, upper) (k,) of the free numbers; of an effect's as far as these recordings reach."""
        lower = np.array([free.lower for free in h.free])
        upper = np.array([free.upper for free in h.free])
        for k, free in enumerate(h.free):
            name, _, parameter = free.path.removeprefix("effects.").partition(".")
            if name not in h.added:
                continue
            effect = catalogue()[h.added[name].effect]
            p = next(p for p in effect.parameters if p.name == parameter)
            least, most = search_limits(effect, p, self.reached)
            if not p.periodic:
                lower[k] = max(lower[k], least)
                upper[k] = max(min(upper[k], most), lower[k])
            if effect.delays:  # no further back than the plant remembers what its encoder showed
                upper[k] = max(min(upper[k], longest_delay(h.base)), lower[k])
            if p.driven:  # a speed that only counts as far as it is driven
                upper[k] = max(min(upper[k], self.fastest), lower[k])
        return lower, upper

    def predict(self, h: Hypothesis, beside: Prediction | None = None, *, side_by_side: bool = False) -> Prediction:
        """What the hypothesis predicts; its recordings ``side_by_side`` where nothing else is.

        The output moves as it does in the prediction ``beside``, where one is given: only the motor's side differs.
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
        """Rows (m,) in units of noise, from what a motion requires [N m], and the encoders' difference [rad]."""
        inertia = plant["motor_inertia"] + (plant["output_inertia"] if plant["two_inertia"] == 0.0 else 0.0)
        scale = plant["torque_constant"] / plant["nominal_torque_constant"]
        torque = (rows[: self.size] + inertia * self.acceleration) / scale + h.lag() * self.rate
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
        """The rows (m,) that each of several hypotheses predicts; those with play or spring are simulated together."""
        from .side_by_side import groups, simulate  # machines without play need not wait for it to load

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

    def alone(self, beside: Prediction, instance: EffectInstance, *, again: bool = False) -> np.ndarray | None:
        """Rows (m,) that one effect adds to a prediction, without simulating it again; None where that is not so.

        What will be asked for ``again``, beside another prediction, is kept as far as it will be the same there.
        """
        effect = catalogue()[instance.effect]
        plant = beside.plant[0]
        if effect.settle is not None:
            return None
        place = effect.where(instance.options)
        if place == DRY_LEVEL and plant["bristle_stiffness"] > 0.0:
            return None
        if place == OUTPUT_TORQUE and (plant["two_inertia"] != 0.0 or beside.by_load):
            return None
        address, slots = effect_address(effect), effect_slots(effect, instance)
        constants = (plant[name].item() for name in ("gear_ratio", "pole_pairs", "torque_constant"))
        key = (address, place, *slots, *constants)
        smoothed = self._kept.get(key) if again else None
        if smoothed is None:
            smoothed = np.zeros(self.size)
            for o, t, required in zip(self.observations, self.torque_parts, beside.required, strict=True):
                torque = np.empty(len(o.motion))
                of = (o.motion, o.motor_origin, o.output_origin, required, torque)
                inverse_dynamics_of(beside.plant, address, place, np.array(slots), *of)
                smooth_at(torque, o.kernel, o.rows, smoothed[t])
            if again and follows_measured_motion(effect, place) and len(self._kept) * smoothed.nbytes < KEPT:
                self._kept[key] = smoothed
        scale = plant["torque_constant"] / plant["nominal_torque_constant"]
        rows = np.zeros(self.rows)
        rows[: self.size] = smoothed / (scale * self.noise)
        return self.whitened(rows)

    def beside(
        self, h: Hypothesis, predicted: Prediction, instance: EffectInstance, *, again: bool = False
    ) -> np.ndarray | None:
        """Rows (m,) that one more effect adds to what a hypothesis predicts, the output moving as it did; None where it
        moves otherwise. Of ``again``, see ``alone``.
        """
        rows = self.alone(predicted, instance, again=again)
        if rows is None and predicted.plant["two_inertia"][0] != 0.0 and _at_the_motor(instance):
            more = h.with_effect(instance.effect, instance.options, instance.parameters)
            rows = EquationErrorProblem.predict(self, more, beside=predicted).rows - predicted.rows
        return rows

    def noise_of_encoders(self, part: slice) -> np.ndarray:
        """Noise [rad] of some of the encoders' rows; ``part`` counts from the first of all rows."""
        return self.encoder_noise[part.start - self.size : part.stop - self.size]

    def residual(self, predicted: Prediction) -> np.ndarray:
        """Measured minus predicted (m,), in units of noise; the encoders' offsets are taken out, robustly."""
        return self.unexplained(predicted.rows)

    def unexplained(self, predicted: np.ndarray) -> np.ndarray:
        """The same of predicted rows (m,)."""
        rows = self.measured - predicted
        if not self.use_encoder:
            rows[self.size :] = 0.0
            return rows
        for e in self.encoder_pieces:
            noise = self.noise_of_encoders(e)
            part = rows[e] - np.median(rows[e] * noise) / noise
            w = 1.0 / (1.0 + (part / self.weighting.cauchy_scale[e]) ** 2)
            rows[e] = part - float(w @ (part / noise)) / float(w @ noise**-2.0) / noise
        return rows

    def left_over(self, predicted: Prediction) -> np.ndarray:
        """The residual (m,) as it was measured, in units of the sensors' noise: what wanders is part of it."""
        rows = self.residual(predicted)
        return rows if self.weighting.wander is None else self.weighting.wander.as_measured(rows)

    def weights(self, residual: np.ndarray) -> np.ndarray:
        """Square roots (m,) of what each row counts: less and less as an outlier."""
        weights = 1.0 / np.sqrt(1.0 + (residual / self.weighting.cauchy_scale) ** 2)
        if not self.use_encoder:
            weights[self.size :] = 0.0
        return weights

    def misfit(self, residual: np.ndarray) -> float:
        """Cauchy's sum: as squares for small residuals, as their logarithm for outliers."""
        return float(self.costs(residual).sum())

    def costs(self, residual: np.ndarray) -> np.ndarray:
        """What each row (m,) adds to the misfit."""
        with np.errstate(over="ignore"):  # what has blown up costs infinitely much
            return self.weighting.cauchy_scale**2 * np.log1p((residual / self.weighting.cauchy_scale) ** 2)

    @property
    def judged(self) -> int:
        """How many rows are judged."""
        return self.rows if self.use_encoder else self.size

    def centred(self, rows: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """Rows with the weighted mean of each recording's encoder rows taken out."""
        rows = rows.copy()
        for e in self.encoder_pieces:
            noise = self.noise_of_encoders(e)
            w = weights[e] ** 2
            if not w.any():  # the torque alone is looked at
                continue
            rows[e] -= float(w @ (rows[e] / noise)) / float(w @ noise**-2.0) / noise
        return rows

    def reweigh(self, residual: np.ndarray, most: float = math.inf) -> bool:
        """Let outliers begin where the bulk of a residual ends, at ``most`` at the latest; True if that moved much."""
        scale = np.full(self.rows, FAR)
        for _, part in self.parts:
            if part.stop > part.start:
                scale[part] = min(most, self.outlier * max(1.0, 1.4826 * float(np.median(np.abs(residual[part])))))
        changed = bool((np.abs(np.log(scale / self.weighting.cauchy_scale)) > SMALL).any())
        if changed:  # a fit's misfit is right for the weighting that it was made under
            self.weighting = replace(self.weighting, cauchy_scale=scale)
        return changed

    def inflate(self, variance: float) -> bool:
        """Hold the priors against a noise of so many times the sensors' variance; True if that moved much."""
        changed = abs(math.log(variance / self.weighting.variance_inflation)) > INFLATED
        if changed:
            self.weighting = replace(self.weighting, variance_inflation=variance)
        return changed

    def jacobian(
        self, h: Hypothesis, predicted: Prediction, weights: np.ndarray, known: Mapping[str, np.ndarray] | None = None
    ) -> np.ndarray:
        """Slopes of the weighted prediction (m, k) to the free numbers; ``known`` are slopes, unweighted, to keep."""
        known = known or {}
        sought = dict.fromkeys(
            free.path.split(".")[1] for free in h.free if free.path.startswith("effects.") and free.path not in known
        )
        now = {name: h.instance(name) for name in sought}
        torques = {name: self.alone(predicted, instance) for name, instance in now.items()}
        steps = [f.step if v + f.step <= f.upper else -f.step for f, v in zip(h.free, h.values, strict=True)]
        moved = [h.put({free.path: h.values[k] + steps[k]}) for k, free in enumerate(h.free)]
        parted = predicted.plant["two_inertia"][0] != 0.0

        def at_the_motor(free: Free) -> bool:
            kind, name, *_ = free.path.split(".")
            return _at_the_motor(now[name]) if kind == "effects" else free.path in AT_THE_MOTOR

        def moves_output(free: Free) -> bool:
            kind, *rest = free.path.split(".")
            if free.path in known or free.path == LAG or kind == "basis":
                return False
            return not at_the_motor(free) and (kind != "effects" or torques[rest[0]] is None)

        moving = [k for k, free in enumerate(h.free) if parted and moves_output(free)]
        simulated = dict(zip(moving, self.rows_of([moved[k] for k in moving]), strict=True)) if moving else {}

        def column(k: int) -> np.ndarray:
            free = h.free[k]
            if free.path in known:
                return known[free.path] * weights
            if free.path.startswith("basis."):
                _, name, place = free.path.split(".")
                return self.generic_bases[name][:, int(place)] * weights
            if free.path == LAG:
                rows = np.zeros(self.rows)
                rows[: self.size] = self.rate / self.noise
                return self.whitened(rows) * weights
            kind, _, rest = free.path.partition(".")
            if kind == "effects":
                name, _, parameter = rest.partition(".")
                held, here = now[name], torques[name]
                if here is not None:
                    values = {**held.parameters, parameter: held.parameters[parameter] + steps[k]}
                    there = self.alone(predicted, EffectInstance(held.effect, held.options, values))
                    assert there is not None  # what acts alone does so with all its numbers
                    return (there - here) / steps[k] * weights
            if k in simulated:
                there = simulated[k]
            else:
                there = self.predict(moved[k], beside=predicted if parted and at_the_motor(free) else None).rows
            return self.centred((there - predicted.rows) / steps[k], weights) * weights

        return np.stack(list(predictions(self.samples, column, range(len(h.free)))), 1)


def follows_measured_motion(effect: Effect, place: int) -> bool:
    """Whether an effect asks for the same torque beside every model of one machine: it follows what was measured."""
    if effect.act is None or is_own(effect) or place in (DRY_LEVEL, VISCOUS_COEFFICIENT):
        return False
    return not OF_THE_MODEL & {*effect.act.__code__.co_names}  # the package's effects ask for values by their names


def _at_the_motor(instance: EffectInstance) -> bool:
    """Whether an effect changes what the motor's side asks for, and nothing of how a parted output moves."""
    effect = catalogue()[instance.effect]
    return effect.act is not None and effect.where(instance.options) != OUTPUT_TORQUE

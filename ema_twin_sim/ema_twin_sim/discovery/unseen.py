"""Validation on unseen data: each recording is simulated with numbers that were fitted to the others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording

from ..comparison.beyond_noise import told_share
from ..comparison.running_comparison import share_removed
from ..criteria import CLEARLY_MORE, FAR_OUT, NOISY, PART, STANDSTILL
from ..identification.equation import EquationErrorProblem
from ..identification.fit import Fit, fit
from ..identification.uncertainty import held_out
from ..identification.unseen_encoders import parting
from ..measured.observation import Observation
from ..model import Model
from ..model.matching import by_torque
from ..model.own_units import in_si, shown
from ..parallel import simulations
from ..plant.balance import BALANCE_LAG, SETTLED
from ..plant.counter import COUNTER_LAG
from ..plant.motion import SPEED, TIME
from ..simulation.longest_step import coarse_step
from ..simulation.simulate import BY_MOTOR, choose_input, simulate
from .search.trace import Search


@dataclass(frozen=True)
class Unseen:
    """RMSE of the main signal for the given model, the start and each later round; pooled, and by recording.

    The start is the given model with its own constants fitted, if that is closer to the recordings: no effect gets
    credit for the refit. The last value is that of the end, before its numbers are fitted once more to the simulated
    loop of all recordings together.

    ``output`` is the pooled RMSE of the output position [rad]; empty if it was not measured. If the current drives the
    twin, whose positions then drift, ``encoders`` is True and ``output`` is the encoder difference that the model does
    not explain.

    ``moving`` is the RMSE that decides. It leaves out standstill if the current drives the twin: rigid friction at rest
    balances any torque below its level, so that whatever describes standstill better would only seem worse there.
    ``settled`` leaves out also what the filters of the unexplained torque carry on from standstill, and with it much of
    the slow motion: a clear fall there counts as an improvement.
    """

    signal: str
    unit: str
    noise_floor: float
    rmse: tuple[float, ...]
    recordings: tuple[tuple[str, tuple[float, ...]], ...]
    output: tuple[float, ...]
    encoders: bool
    given: float
    given_recordings: tuple[float, ...]
    given_output: float | None
    moving: tuple[float, ...]
    settled: tuple[float, ...]
    judged_from: float  # reference of the end, by ``moving``: the given model; if constants are open, all fitted
    judged_from_output: float | None

    @property
    def refitted(self) -> bool:
        """Whether the start differs from the given model."""
        return self.rmse[0] != self.given

    @property
    def refit_removed(self) -> float | None:
        """Share of the excess above the noise floor that was removed by fitting the given model's own constants."""
        return _told(share_removed(self.given, self.rmse[0], self.noise_floor))

    @property
    def betters(self) -> bool:
        """Whether the end is closer to the recordings than the start.

        Closer in the main signal or in the encoder difference; or clearly closer in the output position without being
        farther in the main signal.
        """
        if self.moving[-1] < self._decided(0):
            return True
        if self.encoders:
            return self.output[-1] < self._decided_output(0)
        return bool(self.output) and (
            self.output[-1] < (1.0 / CLEARLY_MORE) * self._decided_output(0) and not self.worsens
        )

    @property
    def worsens(self) -> bool:
        """Whether the end is clearly farther from the recordings than the start."""
        return self.moving[-1] > CLEARLY_MORE * max(self._decided(0), self.noise_floor)

    def clearly_less(self, before: int, after: int) -> bool:
        """Whether the settled error of a round is clearly less than that of another one."""
        return CLEARLY_MORE * self.settled[after] < self.settled[before]

    def mostly_left(self, before: int) -> bool:
        """Whether more of the excess above the noise floor stayed than went, from a round to the end.

        In all recordings together, and in most of those that began with an excess. Where the loop was far off it hunts
        or hits the teeth, and stays far off with the right effects too: such a recording tells nothing.
        """
        together = self.removed(before, len(self.moving) - 1)
        begun = [values for _, values in self.recordings if values[before] > NOISY * self.noise_floor]
        close = [values for values in begun if values[before] < FAR_OUT * self.noise_floor]
        shares = [share_removed(values[before], values[-1], self.noise_floor) for values in close]
        left = [share for share in shares if share is not None and share < 0.5]
        return together is not None and together < 0.5 and len(left) > 0.5 * len(begun)

    def removed(self, before: int, after: int) -> float | None:
        """Share of the excess above the noise floor that was removed between two rounds; None if there is no excess."""
        return share_removed(self._decided(before), self.moving[after], self.noise_floor)

    def output_removed(self, before: int, after: int) -> float:
        """Share, in power, of the output's error that was removed between two rounds; 0 if it is not judged.

        If a measured current drives the twin, the encoder difference is used instead.
        """
        if not self.output or not self._decided_output(before):
            return 0.0
        return 1.0 - (self.output[after] / self._decided_output(before)) ** 2

    def credit(self, turn: int) -> float | None:
        """Share (0 to 1) of the excess above the noise floor that one round removed; None if there is no excess."""
        return _told(share_removed(self.rmse[turn], self.rmse[turn + 1], self.noise_floor))

    def _decided(self, turn: int) -> float:
        return self.moving[turn] if turn else self.judged_from

    def _decided_output(self, turn: int) -> float:
        return self.output[turn] if turn or self.judged_from_output is None else self.judged_from_output

    def shown(self, model: Model) -> Unseen:
        """Same values in the units of the model's machine."""
        per, unit = shown(model, 1.0, self.unit)
        return replace(self._times(per, shown(model, 1.0, "rad")[0]), unit=unit)

    def as_torque(self, constant: float) -> Unseen:
        """Errors of a current [A] as those of the torque that was recorded in its place; ``constant`` [N m/A]."""
        return replace(self._times(constant, 1.0), signal="motor_torque", unit="N m")

    def _times(self, per: float, way: float) -> Unseen:
        """The errors of the main signal times ``per``, and those of the output times ``way``."""
        return replace(
            self,
            noise_floor=per * self.noise_floor,
            rmse=tuple(per * value for value in self.rmse),
            recordings=tuple((name, tuple(per * value for value in values)) for name, values in self.recordings),
            output=tuple(way * value for value in self.output),
            given=per * self.given,
            given_recordings=tuple(per * value for value in self.given_recordings),
            given_output=None if self.given_output is None else way * self.given_output,
            moving=tuple(per * value for value in self.moving),
            settled=tuple(per * value for value in self.settled),
            judged_from=per * self.judged_from,
            judged_from_output=None if self.judged_from_output is None else way * self.judged_from_output,
        )

    def as_json(self) -> dict[str, object]:
        """For ``--json``."""
        output = "encoder_difference" if self.encoders else "output_position"
        return {
            "signal": self.signal,
            "unit": self.unit,
            "noise_floor": self.noise_floor,
            "rmse": list(self.rmse),
            "settled": list(self.settled),
            output: list(self.output),
            "recordings": [{"name": name, "rmse": list(values)} for name, values in self.recordings],
            "as_given": {
                "rmse": self.given,
                output: self.given_output,
                "recordings": [
                    {"name": name, "rmse": value}
                    for (name, _), value in zip(self.recordings, self.given_recordings, strict=True)
                ],
            },
            "refit_removed": self.refit_removed,
        }


def _told(share: float | None) -> float | None:
    return None if share is None else told_share(share)


def squares(
    model: Model, recording: Recording, source: str, signals: Sequence[str], parts: Sequence[np.ndarray] = ()
) -> np.ndarray:
    """(sum of squared errors, samples) of a simulated loop for each signal, one after the other (2 s,).

    For each of the ``parts`` (n,), samples of the recording, two more follow: the same of the first signal in these
    alone. NaN if the motion cannot be simulated with these numbers.
    """
    try:
        twin = simulate(model, recording, source, step=coarse_step(model))
    except InputError:
        return np.full(2 * (len(signals) + len(parts)), np.nan)
    residuals = []
    for name in signals:
        measured = 0.0 if name == "unexplained_torque" else recording.signals.get(name, np.nan)
        residuals.append(np.asarray(measured - twin.signals.get(name, np.nan)))
    residuals += [residuals[0][part] for part in parts]
    found = []
    for residual in residuals:
        counted = residual[np.isfinite(residual)]
        found += [float(counted @ counted), len(counted)]
    return np.array(found)


def _in_motion(o: Observation, recording: Recording, model: Model) -> tuple[np.ndarray, np.ndarray]:
    """Samples (n,) of a recording (SI) in which its motor moves, and those whose filters carry on no standstill.

    The same ones if hardly any are left: that would be the fastest alone. ``o`` is in the own units of the ``model``.
    """
    if o.of_points:
        return np.ones(len(recording), bool), np.ones(len(recording), bool)
    second, _ = shown(model, 1.0, "s")
    moves = np.interp(recording.time / second, o.motion[:, TIME], np.abs(o.motion[:, SPEED])) >= STANDSTILL
    stood = np.maximum.accumulate(np.where(moves, -np.inf, recording.time))
    settled = recording.time - stood > _settling(recording)
    return moves, settled if np.count_nonzero(settled) > PART * np.count_nonzero(moves) else moves


def _settling(recording: Recording) -> float:
    """Seconds after which the filters of the unexplained torque have forgotten what was before."""
    return SETTLED * (BALANCE_LAG if recording.has("speed") else COUNTER_LAG)


class Judge:
    """Simulates recordings after every round of a search. What was simulated for a fit is not simulated again.

    ``recordings`` are in SI, ``given`` (SI) is the model as it was given, ``noise`` the noise floor of all recordings.
    """

    def __init__(self, recordings: Sequence[Recording], given: Model, noise: Mapping[str, float]) -> None:
        self.recordings = recordings
        self.given = given
        self.noise = noise
        self._simulated: dict[tuple[EquationErrorProblem, Fit | None], np.ndarray] = {}
        self._held_out: dict[tuple[EquationErrorProblem, Fit], tuple[list[np.ndarray], np.ndarray]] = {}

    def __call__(self, found: Search, *, as_given: bool = False) -> Unseen:
        """The errors after every round, each recording with the numbers fitted to the others.

        With ``as_given`` the end is the given model, unchanged.
        """
        recordings, problem, base = self.recordings, found.problem, found.fit.hypothesis.base
        inputs = [choose_input(recording, base) for recording in recordings]
        driven = any(source == "current" for source in inputs)  # one main signal for all recordings
        if driven:
            inputs = ["current"] * len(recordings)
            _refuse_unsettled(recordings)
        signal, unit = ("unexplained_torque", "N m") if driven else ("current", "A")
        if {*inputs} == {BY_MOTOR}:
            signal, unit = "output_position", "rad"
        fits: list[Fit] = [found.rounds[0].before, *(turn.after for turn in found.taken)]
        if len(fits) == 1 or fits[-1] is not found.fit:
            fits.append(found.fit)
        parts = [
            _in_motion(o, recording, base) if driven else 2 * (np.ones(len(recording), bool),)
            for o, recording in zip(problem.observations, recordings, strict=True)
        ]
        cases = list(zip(recordings, inputs, parts, strict=True))
        fitted = fits[:-1] if as_given else fits
        ends: list[Fit | None] = [None, *fitted, *([None] if as_given else [])]
        table = self._squares(problem, ends, cases, (signal, "output_position"))
        squared, counts = table[..., 0], table[..., 1]
        each = np.sqrt(squared[:, :, 0] / np.maximum(counts[:, :, 0], 1))
        pooled = np.sqrt(squared.sum(axis=1) / np.maximum(counts.sum(axis=1), 1))
        moving, settled = pooled[:, -2:].T  # a view
        of_output: list[float] = []
        if signal == "current" and counts[:, :, 1].sum(axis=1).all():
            of_output = [float(value) for value in pooled[:, 1]]
        elif driven and problem.rows > problem.size:
            unmoved = [f.hypothesis for f in (fits[0], *(fits[-1:] if as_given else []))]
            first, *last = (problem.residual(problem.predict(h)) for h in unmoved)
            left = [first, *(self._by_others(problem, f)[1] for f in fitted), *last]
            of_output = [parting(problem, residual) for residual in left]
        start = int(base.is_open)
        judged_from = float(moving[start]), of_output[start] if of_output else None
        if as_given or not pooled[1, 0] < pooled[0, 0]:  # fitting open constants while an effect is missing may mislead
            pooled[1], each[1] = pooled[0], each[0]
            of_output[1:2] = of_output[:1]
        unseen = Unseen(
            signal,
            unit,
            self.noise[signal],
            tuple(float(value) for value in pooled[1:, 0]),
            tuple((r.name, tuple(float(v) for v in each[1:, k])) for k, r in enumerate(recordings)),
            tuple(of_output[1:]),
            driven and bool(of_output),
            float(pooled[0, 0]),
            tuple(float(value) for value in each[0]),
            of_output[0] if of_output else None,
            tuple(float(value) for value in moving[1:]),
            tuple(float(value) for value in settled[1:]),
            *judged_from,
        )
        if signal == "current" and by_torque(recordings):
            return unseen.as_torque(self.given.value("machine.torque_constant"))
        return unseen

    def _by_others(self, problem: EquationErrorProblem, f: Fit) -> tuple[list[np.ndarray], np.ndarray]:
        """The numbers to judge each recording by, and what they leave in it (see ``held_out``)."""
        if (problem, f) not in self._held_out:
            self._held_out[problem, f] = held_out(problem, f)
        return self._held_out[problem, f]

    def _squares(
        self,
        problem: EquationErrorProblem,
        ends: Sequence[Fit | None],
        cases: Sequence[tuple[Recording, str, tuple[np.ndarray, np.ndarray]]],
        signals: Sequence[str],
    ) -> np.ndarray:
        """What ``squares`` gives (e, R, signals + 2, 2) for fits, and for the given model in the place of None."""
        fresh = [f for f in dict.fromkeys(ends) if (problem, f) not in self._simulated]
        jobs: list[tuple[Recording, str, tuple[np.ndarray, np.ndarray], Model]] = []
        for f in fresh:
            models = [self.given] * len(cases)
            if f is not None:
                models = [in_si(f.hypothesis.at(values).model()) for values in self._by_others(problem, f)[0]]
            jobs += [(*case, model) for case, model in zip(cases, models, strict=True)]
        rows = list(simulations(lambda job: squares(job[3], job[0], job[1], signals, job[2]), jobs))
        tables = np.array(rows).reshape(len(fresh), len(cases), len(signals) + 2, 2)
        self._simulated |= {(problem, f): table for f, table in zip(fresh, tables, strict=True)}
        return np.stack([self._simulated[problem, f] for f in ends])


def gain_where_unseen(f: Fit) -> float:
    """Gain of the added effects on held-out recordings, each predicted with numbers fitted to all others.

    In units of the remaining noise, relative to constants fitted without the effects. The simulated loop cannot show
    what a fast wave removes (it soon loses the phase), nor what only the encoders show. Generic bases are left out: a
    dependence on the time of one recording cannot be predicted from any other.
    """
    problem, effects = f.problem, f.hypothesis.without_generic_bases()
    bare = effects.without(*effects.added)
    costs = []
    beside = fit(problem, effects, known=f) if f.hypothesis.generic_bases else f
    for one in (fit(problem, bare, known=f), beside):
        _, left = held_out(problem, one)
        costs.append(problem.costs(left))
    noise = np.repeat(f.variance_inflations, (problem.size, problem.rows - problem.size))
    return float(np.sum((costs[0] - costs[1]) / noise))


def _refuse_unsettled(recordings: Sequence[Recording]) -> None:
    """Refuse recordings that all end before the filters of the unexplained torque have settled."""
    settling = [_settling(recording) for recording in recordings]
    if recordings and all(r.duration <= time for r, time in zip(recordings, settling, strict=True)):
        longest = max(recordings, key=lambda recording: recording.duration)
        raise InputError(
            f"{longest.name}: lasts {longest.duration:.3g} s, and no recording lasts longer; the unexplained torque is "
            f"known after {max(settling):.2g} s: give longer recordings"
        )

"""Fit: the parameters of a given model from recordings of its machine, with standard errors and warnings."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording

from ..comparison.compare import of_the_drive, shown_errors
from ..comparison.torque_error import TorqueError, torque_error
from ..criteria import CONTRADICTED
from ..effects import catalogue
from ..identification.equation import EquationErrorProblem
from ..measured.consistency import refuse_inconsistent
from ..measured.folds import operating_point_folds
from ..measured.noise import noise_of
from ..measured.observability import at_rest, restored
from ..measured.observe import observe_all
from ..measured.scales import to_own_units, to_rotary_equivalent
from ..measured.switching_ripple import with_switching_ripple
from ..model import Model
from ..model.constants import CONSTANTS
from ..model.own_units import in_si, native_as_given, shown_entry
from ..simulation.angle_origins import without_common_zero
from ..simulation.simulate import BY_MOTOR, POINTWISE, choose_input
from .doubts import no_nearer, still_far
from .equation_misfit import LAG, EquationMisfit
from .findings import Finding, asleep, find, not_given
from .free_parameters import FreeParameters, choose_numbers, not_by_encoders
from .misfit import Misfit
from .plausibility import circumstances
from .simulation_misfit import SimulationMisfit
from .solver import FINAL, ROUGH, Solution, solve
from .starts import explored, open_start, structural_starts
from .uncertainty import Uncertainty, solved, uncertainty, weigh
from .unseen import Errors, errors_of, judge

METHODS = ("equation", "simulation")
MUCH = 1.5  # change of the row variance after which a fit is repeated

Progress = Callable[[str], None]


@dataclass(frozen=True)
class FitResult:
    """A fitted model and the statistics of its parameters; ``as_json`` is what ``fit --json`` writes.

    ``parameters`` are by instance and ``constants`` by part, each as ``{value, std, unit}`` in SI units. ``std`` is
    None if the number was held, or if it is a constant that the recordings do not determine. ``before`` and ``after``
    are errors per signal on data that was not fitted to, described by ``judged_on``. ``correlations`` (k, k) belong to
    ``paths`` (k,).
    """

    model: Model
    method: str
    input: str
    parameters: dict[str, dict[str, Any]]
    constants: dict[str, dict[str, dict[str, Any]]]
    before: Errors
    after: Errors
    judged_on: str
    paths: tuple[str, ...]
    correlations: tuple[tuple[float, ...], ...]
    warnings: tuple[Finding, ...]
    notes: tuple[str, ...]
    recordings: tuple[str, ...]  # names
    torque_errors: dict[str, TorqueError]  # by recording, if the current (or torque) drives the twin

    def as_json(self) -> dict[str, object]:
        """SI units; numbers that were held have no standard error."""
        return {
            "model": self.model.name,
            "machine": self.model.machine,
            "recordings": list(self.recordings),
            "method": self.method,
            "input": self.input,
            "parameters": self.parameters,
            "constants": self.constants,
            "rmse": {
                signal: {
                    "before": error["rmse"],
                    "after": self.after[signal]["rmse"],
                    "noise_floor": error["noise_floor"],
                    "unit": error["unit"],
                    "driven": error["driven"],
                }
                for signal, error in self.before.items()
            },
            "judged_on": self.judged_on,
            "torque_error": {name: error.as_json() for name, error in self.torque_errors.items()},
            "correlations": {"paths": list(self.paths), "matrix": [list(row) for row in self.correlations]},
            "warnings": [vars(warning) for warning in self.warnings],
            "notes": list(self.notes),
        }


def fit_model(
    recordings: Sequence[Recording],
    model: Model,
    *,
    method: str | None = None,
    free: Sequence[str] = (),
    fix: Sequence[str] = (),
    source: str | None = None,
    progress: Progress = lambda text: None,
) -> FitResult:
    """Fit a model's parameters to recordings.

    ``method`` is ``equation`` (the torque that the measured motion needs) or ``simulation`` (the closed loop compared
    with the recording). The default is the simulation, or the equation if the current drives the twin. ``free`` and
    ``fix`` name paths (``effects.backlash.width``, ``machine.motor_inertia``) or prefixes of paths; by default the
    parameters of all effects and the inertias are free. ``source`` is the input (see ``choose_input``); ``progress`` is
    called with a description of each stage. Raises InputError if the recordings cannot be fitted to.
    """
    noise = noise_of(recordings, model)
    given, names = model, tuple(recording.name for recording in recordings)
    rotary, as_filed = to_rotary_equivalent(recordings, model)
    rotary = operating_point_folds(rotary, as_filed)
    recordings, model = to_own_units(recordings, model)
    recordings, awake = operating_point_folds(recordings, model), model
    model = at_rest(model, recordings)
    doubts = refuse_inconsistent(recordings, model)
    sources = [choose_input(recording, model, source) for recording in recordings]
    method = method or ("equation" if {"current", POINTWISE} & {*sources} else "simulation")
    if method == "simulation" and POINTWISE in sources:
        raise InputError(f"{recordings[0].name}: operating points are fitted by --method equation: nothing runs there")
    if method not in METHODS:
        raise InputError(f"method '{method}' is not known; give {' or '.join(METHODS)}")
    if {*sources} == {BY_MOTOR}:
        if not free and not _parts_encoders(model):
            raise InputError(
                f"model {model.name}: has no play, spring, delay or angle error, and {recordings[0].name} (two "
                "encoders, no torque) shows nothing else; run discover"
            )
        fix = (*fix, *not_by_encoders(model, free))
    freedom = choose_numbers(model, free, fix)
    misfit, solution, sure, loosened = _solution(recordings, sources, method, freedom, progress)
    progress("judging on held-out data")
    as_given, own_before = in_si(model), None
    if model.is_open:
        with suppress(InputError):  # a model whose constants are guesses may be one that cannot be simulated at all
            as_given, own_before = as_filed, errors_of(as_filed, rotary, sources, noise)
    own_before = own_before or errors_of(as_given, rotary, sources, noise)
    before, after, judged_on = judge(rotary, sources, as_given, own_before, misfit, solution, noise)
    untold = not_given(solution, method)
    values = solution.values[: len(freedom.numbers)].copy()
    values[untold] = freedom.start[untold]
    fitted = freedom.at(values)
    findings = asleep(awake, model) + find(solution, sure, fitted, method, circumstances(recordings, fitted))
    findings += [Finding("recording", "", "", text) for text in doubts]
    findings += [Finding("recording", r.name, "", text) for r in recordings for text in r.warnings]
    blind = without_common_zero(recordings, fitted.active.values())
    findings += [Finding("recording", recordings[0].name, "", text) for text in blind]
    shown = [k for k, number in enumerate(solution.freedom.numbers) if number.path != LAG]
    own_before, own_after, before, after = (
        shown_errors(as_given, of_the_drive(as_given, each, rotary))
        for each in (own_before, errors_of(in_si(fitted), rotary, sources, noise), before, after)
    )
    hit = _parts_encoders(fitted)
    notes = no_nearer(own_before, own_after, before, after, by_equation=method == "equation", hit=hit)
    notes += [*freedom.notes, *still_far(after, hit)]
    for k in loosened:
        path = model.shown_path(solution.freedom.numbers[k].path)
        notes.append(f"{path}: these recordings contradict its nominal value, which was let go")
    return FitResult(
        native_as_given(restored(fitted, awake), given).fitted_from(given),
        method,
        sources[0] if len(set(sources)) == 1 else "mixed",
        _parameters(fitted, solution, sure),
        _constants(given, fitted, solution, sure, untold),
        before,
        after,
        judged_on,
        tuple(model.shown_path(solution.freedom.numbers[k].path) for k in shown),
        tuple(tuple(float(sure.correlation[a, b]) for b in shown) for a in shown),
        tuple(findings),
        tuple(notes),
        names,
        {
            recording.name: error
            for recording, chosen in zip(rotary, sources, strict=True)
            if chosen == "current" and (error := torque_error(recording, in_si(fitted))) is not None
        },
    )


def _solution(
    recordings: Sequence[Recording], sources: Sequence[str], method: str, freedom: FreeParameters, progress: Progress
) -> tuple[Misfit, Solution, Uncertainty, list[int]]:
    """The misfit, its best solution with its uncertainty, and the parameters whose priors the recordings contradict.

    A simulation fit starts from the result of the equation fit, which is fast and converges from farther away.
    """
    progress("reading the motion")
    observations = [with_switching_ripple(o, freedom.model) for o in observe_all(list(recordings), freedom.model)]
    if method == "equation" and freedom.model.is_open and not _parts_encoders(freedom.model):
        # no parameter affects the encoder rows: for an unknown machine they would only inflate the misfit
        observations = [o.without_encoders() for o in observations]
    equation = EquationErrorProblem(observations)
    freedom = freedom.within(equation.reached)
    starts = structural_starts(equation, freedom, progress)
    if freedom.model.is_open and starts[0] is freedom.start:
        starts[0] = open_start(equation, freedom)
    equated = EquationMisfit(equation, freedom)
    solution = explored(equated, starts[0], FINAL if method == "equation" else ROUGH, progress)
    misfit: Misfit = equated
    if method == "simulation":
        progress("simulating")
        simulated = SimulationMisfit(recordings, observations, freedom, sources)
        starts += [solution.values[: len(freedom.numbers)], *(() if starts[0] is freedom.start else (freedom.start,))]
        start = min(starts, key=lambda values: _cost(simulated, values))
        simulated.doubt(start)
        simulated.reweigh(simulated.residual(start))
        solution = solve(simulated, start, progress=progress)
        misfit = simulated
    if weigh(misfit, solution) > MUCH:
        solution = solve(misfit, solution.values, progress=progress)
    sure = uncertainty(misfit, solution)
    loosened = _contradicted(solution, sure)
    if loosened:
        misfit.freedom = misfit.freedom.with_priors_loose(loosened)
        solution = solve(misfit, solution.values, progress=progress)
        sure = uncertainty(misfit, solution)
    values = solution.values.copy()
    for k, number in enumerate(misfit.freedom.numbers):
        if number.periodic:
            values[k] = math.remainder(values[k], 2.0 * math.pi)
    return misfit, replace(solution, values=values), sure, loosened


def _parts_encoders(model: Model) -> bool:
    """Whether any effect of a model lets its encoders differ."""
    return any(catalogue()[instance.effect].depends_on == "encoders" for instance in model.active.values())


def _cost(misfit: SimulationMisfit, values: np.ndarray) -> float:
    """Cost of a start; infinite if no twin can be simulated with it at the coarsest step used."""
    try:
        misfit.check(values)
        return misfit.cost(misfit.residual(values))
    except InputError:
        return math.inf


def _contradicted(solution: Solution, sure: Uncertainty) -> list[int]:
    """Parameters that these recordings move away from the model file with confidence."""
    found = []
    for k, (number, x) in enumerate(zip(solution.freedom.numbers, solved(solution), strict=True)):
        mean, std = number.solver_prior
        if number.known and abs(x - mean) > CONTRADICTED * max(std, float(sure.std[k])):
            found.append(k)
    return found


def _spread(path: str, solution: Solution, sure: Uncertainty) -> float | None:
    """Standard error of the number at a path; None if it was held."""
    k = solution.freedom.index(path)
    if k is None:
        return None
    number = solution.freedom.numbers[k]
    share = number.shares[number.paths.index(path)]
    return float(sure.std[k]) * number.slope(float(solution.values[k])) * abs(share)


def _parameters(fitted: Model, solution: Solution, sure: Uncertainty) -> dict[str, dict[str, Any]]:
    found: dict[str, dict[str, Any]] = {}
    for name, instance in fitted.effects.items():
        if not instance.enabled:
            continue
        found[name] = {"effect": instance.effect, "options": dict(instance.options)}
        for p in catalogue()[instance.effect].parameters_with(instance.options):
            value = instance.parameters[p.name]
            std = _spread(f"effects.{name}.{p.name}", solution, sure)
            found[name][p.name] = shown_entry(fitted, value, std, p.unit, angle=p.periodic)
    return found


def _constants(
    given: Model, fitted: Model, solution: Solution, sure: Uncertainty, untold: Sequence[int]
) -> dict[str, dict[str, dict[str, Any]]]:
    found: dict[str, dict[str, dict[str, Any]]] = {}
    for path, constant in CONSTANTS.items():
        k = solution.freedom.index(path)
        if k is not None:
            std = None if k in untold else _spread(path, solution, sure)
            entry = shown_entry(fitted, fitted.value(path), std, constant.unit)
            name = given.shown_path(path).partition(".")[2]
            found.setdefault(constant.part, {})[name] = {**entry, "nominal": given.value(path)}
    return found

"""Zeros of the motor's position that differ from the one at which a model's own waves were found.

An incremental counter starts anew when it is switched on. A model that holds the torques which repeat with the motor's
angle then tells, of every further recording, by how much its zero is off: by as much as its waves are.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording

from ..comparison.orders import FEWEST_CYCLES
from ..effects import catalogue
from ..identification.equation import EquationErrorProblem
from ..identification.fit import fit
from ..identification.null_hypothesis import null_hypothesis
from ..listing import listed
from ..measured.observe import observe_all
from ..measured.quieter_motion import as_measured
from ..measured.scales import to_own_units
from ..model import Model
from ..model.own_units import is_linear
from ..quantities import quantity
from ..simulation.angle_origins import acts_at_an_angle
from .differing_zeros import (
    as_recorded,
    best_shift,
    lines_of,
    over_the_angle,
    tried_shifts,
    wave_at,
    with_zeros_moved,
)

SAMPLES = 100_000  # of a recording that tell its zero; a longer one is not read to its end for it


def with_the_models_zeros(recordings: Sequence[Recording], model: Model) -> tuple[list[Recording], tuple[str, ...]]:
    """The recordings, with the zeros of their positions moved to where the ``model`` says, and what to say of it."""
    by = zeros_by_model(recordings, model)
    if not by:
        return list(recordings), ()
    unit = "m" if is_linear(model) else "rad"
    each = listed(f"{quantity(way, unit)} for {name}" for name, way in by.items())
    return with_zeros_moved(recordings, by), (
        f"the position's zero differs from the one of {model.name}, as that of a counter does that starts anew: what "
        f"repeats along it in the model begins elsewhere in the recordings. Their zeros are moved by {each}",
    )


def zeros_by_model(recordings: Sequence[Recording], given: Model) -> dict[str, float]:
    """How far to move the zeros of the recordings' positions, in their own unit; those that agree are left out.

    Empty for a model without a torque at an angle, or if nothing tells the zeros: with an encoder on the output as
    well, or for operating points.
    """
    at_an_angle = [name for name, held in given.active.items() if acts_at_an_angle(catalogue()[held.effect])]
    if not at_an_angle or not given.other_orders or not all(r.has("motor_position") for r in recordings):
        return {}
    try:
        measured = as_measured([_first_samples(recording) for recording in recordings], given)
        own, model = to_own_units(measured, given)
        problem = EquationErrorProblem(observe_all(own, model))
    except InputError:
        return {}  # nothing can be judged by torque; whoever judges the recordings says why
    if not problem.size or problem.rows > problem.size:
        return {}
    bare = model
    for name in at_an_angle:
        bare = bare.with_enabled(name, False)
    without = fit(problem, null_hypothesis(bare))
    whole = null_hypothesis(model)
    known = {path: value for path, value in without.hypothesis.by_path.items() if path in whole.by_path}
    waves = problem.residual(without.predicted) - problem.residual(
        problem.predict(whole.put({**whole.by_path, **known}))
    )
    return as_recorded(own, _shifts(problem, without.residual, waves * without.weights, linear=is_linear(model)), model)


def _shifts(problem: EquationErrorProblem, left: np.ndarray, waves: np.ndarray, *, linear: bool) -> dict[str, float]:
    """The shift [rad] of each recording at which its waves in what is ``left`` (m,) are the model's ``waves`` (m,)."""
    found: dict[str, float] = {}
    of_model = over_the_angle(problem, waves)
    for name, (values, angle) in over_the_angle(problem, left).items():
        lines, _ = lines_of([of_model[name]])
        lines = [line for line in lines if line.order * float(np.ptp(angle)) >= 2.0 * np.pi * FEWEST_CYCLES]
        if not lines:
            continue
        tried = tried_shifts([line.order for line in lines], linear=linear)
        score, of_model_alone, rest = np.zeros(len(tried)), 0.0, values
        for line in lines:
            wave, rest = wave_at(line.order, rest, angle)
            score += len(values) * np.real(wave * np.conj(line.waves[0]) * np.exp(-1j * line.order * tried))
            of_model_alone += 0.5 * len(values) * abs(line.waves[0]) ** 2
        if score.max() <= of_model_alone:
            continue  # wherever it begins, the model's wave would only add to the error: it is not there
        if shift := best_shift(tried, score / float(rest.var()), max(line.order for line in lines)):
            found[name] = shift
    return found


def _first_samples(recording: Recording) -> Recording:
    if len(recording) <= SAMPLES:
        return recording
    return recording.between(None, float(recording.time[SAMPLES]))

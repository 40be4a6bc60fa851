"""Zeros of the motor's position that differ from the one at which a model's own waves or loads were found.

An incremental counter starts anew when it is switched on. A model that holds the torques which repeat with the motor's
angle, or a load at an angle, then tells of every further recording by how much its zero is off: as much as these are.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from statistics import median_low

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording

from ..comparison.orders import FEWEST_CYCLES
from ..criteria import NEGLIGIBLE
from ..identification.equation import EquationErrorProblem
from ..identification.fit import Fit, fit
from ..identification.loads_at_an_angle import loads_of
from ..identification.null_hypothesis import null_hypothesis
from ..listing import listed
from ..measured.observe import observe_all
from ..measured.quieter_motion import as_measured
from ..measured.scales import to_own_units
from ..model import Model
from ..model.own_units import is_linear
from ..quantities import quantity
from .differing_zeros import (
    as_recorded,
    best_shift,
    lines_of,
    over_the_angle,
    tried_shifts,
    wave_at,
    waves_of,
    with_zeros_moved,
)
from .zeros_by_load import zeros_by_known_load

SAMPLES = 100_000  # of a recording that tell its zero: those of its longest way


def with_the_models_zeros(
    recordings: Sequence[Recording], model: Model, *, between_them: bool = False
) -> tuple[list[Recording], tuple[str, ...]]:
    """The recordings, with the zeros of their positions moved to where the ``model`` says, and what to say of it.

    ``between_them``: only by what they differ from each other, since the model's own angle is still to be fitted. The
    first recording that is moved carries the warning. Where a load is the same way off in all recordings, none is
    moved: it may be the model that is wrong.
    """
    by = zeros_by_model(recordings, model)
    if between_them:
        by = _apart(recordings, by)
    if not by:
        return list(recordings), ()
    if not _telling_waves(model) and not _apart(recordings, by):
        return list(recordings), (_of_another_angle(by, model),)
    unit = "m" if is_linear(model) else "rad"
    each = listed(f"{quantity(way, unit)} for {name}" for name, way in by.items())
    told = (
        f"the zeros of the positions differ from the one of {model.name}, as those of a counter do that starts anew: "
        f"they are moved by {each}. If the encoder is absolute, the angles of the model are wrong instead: run fit"
    )
    moved = with_zeros_moved(recordings, by)
    first = next(k for k, recording in enumerate(moved) if recording.name in by)
    moved[first] = replace(moved[first], warnings=(*moved[first].warnings, told))
    return moved, (told,)


def _of_another_angle(by: Mapping[str, float], model: Model) -> str:
    """Question about a load that acts elsewhere in all recordings by the same way: a weight more would look alike."""
    way = quantity(median_low(by.values()), "m" if is_linear(model) else "rad")
    return (
        f"these recordings fit {listed(loads_of(model))} of {model.name} at another angle: by {way} of the positions, "
        "in all of them. If their counters started anew, add that to the positions; otherwise run fit for the angle, "
        "or discover for a further load"
    )


def has_a_zero(model: Model) -> bool:
    """Whether a model has a torque at an angle, on a machine whose counter may start anew."""
    return bool(loads_of(model) or _telling_waves(model))


def _telling_waves(model: Model) -> list[str]:
    """The waves of a model by which a zero is told; none if the model names all orders that there are."""
    return waves_of(model) if model.other_orders else []


def zeros_by_model(recordings: Sequence[Recording], given: Model) -> dict[str, float]:
    """How far to move the zeros of the recordings' positions, in their own unit; those that agree are left out.

    The load of the model tells it, and its waves tell it more closely. Empty for a model without a torque at an angle,
    or if nothing tells the zeros: with an encoder on the output as well. Recordings without a position, and operating
    points, are left as they are.
    """
    by: dict[str, float] = {}
    if loads_of(given):
        by = _by(recordings, given, loads_of(given), zeros_by_known_load)
    if waves := _telling_waves(given):
        more = _by(with_zeros_moved(recordings, by), given, waves, _by_waves)
        by = {name: by.get(name, 0.0) + more.get(name, 0.0) for name in {**by, **more}}
    return by


def _by(
    recordings: Sequence[Recording],
    given: Model,
    effects: Sequence[str],
    ways: Callable[[Fit, Model], Mapping[str, float]],
) -> dict[str, float]:
    """What ``ways`` [rad, motor] tells of a fit without some effects of a model in own units, as it was recorded."""
    telling = _telling(recordings)
    if not telling:
        return {}
    try:
        measured = as_measured([_longest_way(recording) for recording in telling], given)
        own, model = to_own_units(measured, given)
        problem = EquationErrorProblem(observe_all(own, model))
    except InputError:
        return {}  # nothing can be judged by torque; whoever judges the recordings says why
    if not problem.size or problem.rows > problem.size:
        return {}
    bare = model
    for name in effects:
        bare = bare.with_enabled(name, False)
    return as_recorded(telling, ways(fit(problem, null_hypothesis(bare)), model), model)


def _by_waves(without: Fit, model: Model) -> dict[str, float]:
    """The shift [rad] of each recording's motor by the waves of a ``model``, given the fit of one without them."""
    problem, whole = without.problem, null_hypothesis(model)
    known = {path: value for path, value in without.hypothesis.by_path.items() if path in whole.by_path}
    there = problem.predict(whole.put({**whole.by_path, **known}))
    waves = problem.residual(without.predicted) - problem.residual(there)
    return _shifts(problem, without.residual, waves * without.weights, linear=is_linear(model))


def _apart(recordings: Sequence[Recording], by: Mapping[str, float]) -> dict[str, float]:
    """The shifts ``by`` less what most of the recordings have in common, which is the model's own phase."""
    if not by:
        return {}
    ways = {r.name: by.get(r.name, 0.0) for r in _telling(recordings)}
    common = median_low(ways.values())
    most = max(map(abs, ways.values()))
    return {name: way - common for name, way in ways.items() if abs(way - common) > NEGLIGIBLE * most}


def _telling(recordings: Sequence[Recording]) -> list[Recording]:
    """The recordings that may tell a zero."""
    return [r for r in recordings if r.has("motor_position") and not r.of_points]


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
        noise = float(rest.var())
        if score.max() <= of_model_alone or not noise > 0.0:
            continue  # wherever it begins, the model's wave would only add to the error: it is not there
        if shift := best_shift(tried, score / noise, max(line.order for line in lines)):
            found[name] = shift
    return found


def _longest_way(recording: Recording) -> Recording:
    """The part of a long recording in which its motor goes farthest: others may be at rest all along."""
    count = len(recording)
    if count <= SAMPLES:
        return recording
    position = recording.signals["motor_position"]

    def way(start: int) -> float:
        part = position[start : start + SAMPLES]
        part = part[np.isfinite(part)]
        return float(np.ptp(part)) if len(part) else 0.0

    at = max(range(0, count - SAMPLES + 1, SAMPLES), key=way)
    first, last = ((recording.stamps[k] - recording.stamps[0]) * 1e-9 for k in (at, at + SAMPLES - 1))
    return recording.between(float(first), float(last))

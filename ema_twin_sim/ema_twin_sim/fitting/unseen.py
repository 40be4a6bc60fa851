"""Errors before and after a fit, on data that was not fitted to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording

from ..comparison.compare import MIXED
from ..comparison.running_comparison import RunningComparison, SignalError
from ..measured.folds import HALF_OF
from ..model import Model
from ..model.own_units import in_si
from ..parallel import simulations
from ..simulation.encoder_difference import Signals, with_encoder_difference
from ..simulation.simulate import simulate
from .misfit import Misfit
from .solver import Solution
from .uncertainty import left_out

LAST = 2.0 / 3.0  # share of a single recording after which it is kept for judging

Errors = dict[str, SignalError]


def judge(
    recordings: Sequence[Recording],
    sources: Sequence[str],
    given: Model,
    of_given: Errors,
    misfit: Misfit,
    solution: Solution,
    noise: Mapping[str, float],
) -> tuple[Errors, Errors, str]:
    """(errors before, errors after, what they were judged on): each recording, with parameters from the others.

    Before: of the ``given`` model; ``of_given`` are its errors over all of the recordings. It and they are in SI;
    ``noise`` is their noise floor.
    """
    if len(recordings) > 1:
        which = np.empty(misfit.rows, int)
        for recording, part in misfit.parts:
            which[part] = recording
        first = [0] * len(recordings)
        said = "each recording with numbers fitted to the others"
        if HALF_OF in recordings[0].metadata:
            said = "each half of the points with numbers fitted to the other"
    else:
        which = np.full(misfit.rows, -1)
        for _, part in misfit.parts:
            which[part.start + int(LAST * (part.stop - part.start)) : part.stop] = 0
        first = [int(LAST * len(recordings[0]))]
        said = "the last third with numbers fitted to the rest"
    freedom = solution.freedom  # with the bounds that were searched
    lower, upper = np.array([n.solved_bounds for n in freedom.numbers]).T
    models = []
    for found in left_out(misfit, solution, which, len(recordings)):
        inside = np.clip(found, lower, upper)  # linear extrapolation may lead anywhere
        values = np.array([n.from_solver(x) for n, x in zip(freedom.numbers, inside, strict=True)])
        models.append(in_si(freedom.at(values)))
    as_given = [given] * len(recordings)
    before = errors(recordings, sources, as_given, as_given, first, noise) if any(first) else of_given
    return before, errors(recordings, sources, models, as_given, first, noise), said


def errors_of(
    model: Model, recordings: Sequence[Recording], sources: Sequence[str], noise: Mapping[str, float]
) -> Errors:
    """Errors of a model, pooled over recordings; it and they are in SI. Raises InputError if it cannot be simulated."""
    alike = [model] * len(recordings)
    return errors(recordings, sources, alike, alike, [0] * len(recordings), noise)


def errors(
    recordings: Sequence[Recording],
    sources: Sequence[str],
    models: Sequence[Model],
    given: Sequence[Model],
    first: Sequence[int],
    noise: Mapping[str, float],
) -> Errors:
    """Errors of models, from sample ``first`` of each recording on; the given model replaces one that cannot run."""

    def signals_of(recording: Recording, source: str, model: Model, instead: Model) -> tuple[Signals, Signals]:
        try:
            twin = simulate(model, recording, source)
        except InputError:  # a parameter that only this recording determines may have any value without it
            model, twin = instead, simulate(instead, recording, source)
        return with_encoder_difference(model, recording, source, twin)

    pairs = list(simulations(signals_of, recordings, sources, models, given))
    together = sources[0] if len(set(sources)) == 1 else MIXED
    pooled = RunningComparison(given[0], together, noise=noise)
    for recording, source, model, pair, start in zip(recordings, sources, given, pairs, first, strict=True):
        one = RunningComparison(model, source, period=recording.sample_period, noise=noise)
        one.add_rows(*({name: v[start:] for name, v in signals.items()} for signals in pair))
        pooled.include(one)
    return pooled.result()

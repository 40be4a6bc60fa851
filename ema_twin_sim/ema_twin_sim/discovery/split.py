"""Split of inertia and friction between the motor side and the output side.

The sums show in every motion. The shares show only while backlash or compliance separates the two sides, and there the
equation error determines them to a few per cent: enough to shift every impact by milliseconds. So the shares of the
model file, and its teeth, are compared with the fitted ones in the closed loop, and the set that follows the recordings
better is kept.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from ema_bench_replay.recording import Recording

from ..criteria import NEGLIGIBLE
from ..identification.fit import fit
from ..identification.hypothesis import Hypothesis
from ..model import Model
from ..parallel import simulations
from ..simulation.simulate import choose_input
from .search.trace import Search
from .unseen import squares


class ClosedLoop:
    """The simulated loop compared with recordings; results are cached by model."""

    def __init__(self, recordings: Sequence[Recording], model: Model) -> None:
        self.recordings = recordings
        self.inputs = [choose_input(recording, model) for recording in recordings]
        self._known: list[tuple[Model, float]] = []

    def errors(self, hypotheses: Iterable[Hypothesis]) -> list[float]:
        """``loop_error`` of each hypothesis."""
        return [self._error(h.model()) for h in hypotheses]

    def _error(self, model: Model) -> float:
        for known, error in self._known:
            if known == model:
                return error
        self._known.append((model, loop_error(model, self.recordings, self.inputs)))
        return self._known[-1][1]


def with_best_split(loop: ClosedLoop, found: Search) -> Search:
    """The search, with the model file's shares (or also its teeth) at its end if these follow the recordings better."""
    best = found.fit
    if not best.parted or not found.taken or {*loop.inputs} != {"setpoint"}:
        return found
    shared = best.hypothesis.holding(best.hypothesis.as_the_file_shares())
    shared = best.hypothesis.at(fit(found.problem, shared).hypothesis.values)  # all numbers free again, at these values
    teeth = shared.teeth_of_the_file()
    others = [shared, *([shared.holding(teeth)] if teeth else [])]
    fitted, *errors = loop.errors((best.hypothesis, *others))
    least = int(np.argmin(errors))
    if not errors[least] < (1.0 - NEGLIGIBLE) * fitted:
        return found
    return found.with_numbers(fit(found.problem, others[least], 0))


def loop_error(model: Model, recordings: Sequence[Recording], inputs: Sequence[str]) -> float:
    """Mean square current error [A2] of the simulated loop, as the geometric mean over the recordings.

    The geometric mean keeps one chaotic recording from deciding for all. Infinite if the loop cannot follow, or is too
    stiff to simulate.
    """
    jobs = zip(recordings, inputs, strict=True)
    table = np.array(list(simulations(lambda job: squares(model, job[0], job[1], ("current",)), jobs)))
    mean = table[:, 0] / np.maximum(table[:, 1], 1.0)
    return float(np.exp(np.mean(np.log(np.maximum(mean, 1e-18))))) if np.isfinite(mean).all() else math.inf

"""Constants that the recordings do not move stay where the model's file has them.

A search frees all constants, and each ends somewhere within its standard error. To have moved that far says nothing
of the machine, yet where teeth meet it puts every impact at another instant. So what is not known to have moved is put
back and the rest fitted again, and the closed loop tells whether it follows the recordings as well.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from ema_bench_replay.recording import Recording

from ..simulation.simulate import choose_input
from .equation import Equation
from .estimates import standard_errors
from .fit import Fit, fit
from .split import held_at, loop_error
from .trace import Search

MOVED = 2.0  # standard errors from its file's value within which a constant is not known to have moved
AS_WELL = 1.02  # of the squared error of the closed loop: what the file's values may cost


def with_unmoved_constants(eq: Equation, recordings: Sequence[Recording], found: Search) -> Search:
    """The search, at its end the constants that did not surely move back at their file's values."""
    best = found.fit
    inputs = [choose_input(recording) for recording in recordings]
    if best.hypothesis.base.is_open or not found.taken or {*inputs} != {"setpoint"}:
        return found
    rest = _put_back(eq, best)
    if rest is None:
        return found
    fitted, put_back = (loop_error(f.hypothesis.model(), recordings, inputs) for f in (best, rest))
    as_well = math.isfinite(put_back) and put_back <= AS_WELL * fitted
    return found.with_numbers(rest) if as_well else found


def _put_back(eq: Equation, best: Fit) -> Fit | None:
    """The fit with the constants that are not known to have moved at their file's values; None where all have."""
    sure = standard_errors(eq, best)
    values = best.hypothesis.by_path
    unmoved = {
        free.path: free.prior[0]
        for free in best.hypothesis.free
        if free.prior is not None and abs(values[free.path] - free.prior[0]) < MOVED * sure.get(free.path, 0.0)
    }
    if not unmoved:
        return None
    rest = fit(eq, held_at(best.hypothesis, unmoved))
    return fit(eq, best.hypothesis.at(rest.hypothesis.values), 0)  # all numbers free again, where they are

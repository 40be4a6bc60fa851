"""First-order predictions from a known two-inertia prediction, without a new simulation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from .equation import EquationErrorProblem
from .hypothesis import Hypothesis
from .prediction import Prediction


@dataclass(frozen=True, eq=False)
class AlongSlopes:
    """Predicts hypotheses near a known one, to first order in what they share with it.

    The shared parameters act along the known ``slopes`` (m,), by path. An effect that is added or removed contributes
    its own torque.
    """

    problem: EquationErrorProblem
    known: Hypothesis
    predicted: Prediction
    slopes: Mapping[str, np.ndarray]

    def holds_for(self, h: Hypothesis) -> bool:
        """Whether this applies to a hypothesis: no added or removed effect changes how the output moves."""
        return h.base is self.known.base and self._changes(h) is not None

    def predict(self, h: Hypothesis, beside: Prediction | None = None, *, side_by_side: bool = False) -> Prediction:
        """Predict the rows of a hypothesis; ``beside`` and ``side_by_side`` are ignored, since nothing is simulated."""
        now = h.by_path
        changes = self._changes(h)
        assert changes is not None  # otherwise it does not apply to this hypothesis
        rows = self.predicted.rows + changes
        for path, value in self.known.by_path.items():
            if path in now or path.startswith("basis."):  # a generic basis that was removed contributes nothing
                rows += self.slopes[path] * (now.get(path, 0.0) - value)
        for path, value in now.items():
            if path.startswith("basis.") and path not in self.slopes:
                _, name, place = path.split(".")
                rows += self.problem.generic_bases[name][:, int(place)] * value
        return replace(self.predicted, rows=rows)

    def rows_of(self, several: Sequence[Hypothesis]) -> list[np.ndarray]:
        """The predicted rows (m,) of several hypotheses."""
        return [self.predict(h).rows for h in several]

    def _changes(self, h: Hypothesis) -> np.ndarray | None:
        """Rows (m,) of the added effects minus those of the removed ones; None if not possible."""
        rows = np.zeros(self.problem.rows)
        for name in h.added:
            if name not in self.known.added:
                more = self.problem.beside(self.known, self.predicted, h.instance(name))
                if more is None:
                    return None
                rows += more
        for name in self.known.added:
            if name not in h.added:
                less = self.problem.alone(self.predicted, self.known.instance(name))
                if less is None:
                    return None
                rows -= less
        return rows

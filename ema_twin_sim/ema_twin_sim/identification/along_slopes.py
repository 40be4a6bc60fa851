"""Predictions along the slopes of a known one whose gearbox is simulated: nothing is simulated again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from .equation import EquationErrorProblem
from .hypothesis import Hypothesis
from .prediction import Prediction


@dataclass(frozen=True, eq=False)
class AlongSlopes:
    """What hypotheses beside a known one predict, to first order in what they share with it.

    The known one's numbers act along their ``slopes`` (m,), by path, and an effect that comes or goes adds what it asks
    for.
    """

    problem: EquationErrorProblem
    known: Hypothesis
    predicted: Prediction
    slopes: Mapping[str, np.ndarray]

    def holds_for(self, h: Hypothesis) -> bool:
        """Whether it is right for a hypothesis: no effect that comes or goes changes how the output moves."""
        return h.base is self.known.base and self._changes(h) is not None

    def predict(self, h: Hypothesis, beside: Prediction | None = None, *, side_by_side: bool = False) -> Prediction:
        """What the hypothesis predicts; nothing is simulated for it, ``beside`` or ``side_by_side``."""
        now = h.by_path
        changes = self._changes(h)
        assert changes is not None  # else it does not hold for this hypothesis
        rows = self.predicted.rows + changes
        for path, value in self.known.by_path.items():
            if path in now or path.startswith("basis."):  # of a generic basis that went, nothing is left
                rows += self.slopes[path] * (now.get(path, 0.0) - value)
        for path, value in now.items():
            if path.startswith("basis.") and path not in self.slopes:
                _, name, place = path.split(".")
                rows += self.problem.generic_bases[name][:, int(place)] * value
        return Prediction(rows, self.predicted.plant, self.predicted.required, self.predicted.by_load)

    def rows_of(self, several: Sequence[Hypothesis]) -> list[np.ndarray]:
        """The rows (m,) that each of several hypotheses predicts."""
        return [self.predict(h).rows for h in several]

    def _changes(self, h: Hypothesis) -> np.ndarray | None:
        """Rows (m,) of the effects that came, less those of the effects that went."""
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

"""Levenberg-Marquardt on a straight line's rows, where the answer is known."""

import importlib
from types import SimpleNamespace

import numpy as np
import pytest

fitting = importlib.import_module("ema_twin_sim.identification.fit")  # the room exports a function of that name

ALIKE = 30.0 * np.linalg.cholesky([[1.0, 0.99], [0.99, 1.0]]).T
"""Slopes of two numbers that do nearly the same."""
FREE = np.array([10.0, -9.0])
"""Where the two would be best."""


class Numbers:
    parted, free = False, ()

    def __init__(self, values):
        self.values = np.asarray(values, float)

    def at(self, values):
        return Numbers(values)


def best(monkeypatch, most):
    """The two values, from zero, none of them beyond ``most``, and how often the rows were predicted."""
    asked = []

    def predict(h, side_by_side=False):
        asked.append(h)
        return SimpleNamespace(rows=ALIKE @ h.values, plant={"two_inertia": [0.0]})

    problem = SimpleNamespace(
        size=2, rows=2, judged=2, weighting=SimpleNamespace(variance_inflation=1.0), predict=predict,
        bounds=lambda h: (np.full(2, -100.0), np.asarray(most)), residual=lambda p: ALIKE @ FREE - p.rows,
        misfit=lambda raw: float(raw @ raw), weights=lambda raw: np.ones(2), costs=np.square,
    )  # fmt: skip
    monkeypatch.setattr(fitting, "jacobian", lambda *_: ALIKE)
    monkeypatch.setattr(fitting, "prior_rows", lambda *_: (np.zeros(0), np.zeros((0, 2))))
    return fitting.fit(problem, Numbers([0.0, 0.0]), 20).hypothesis.values, len(asked)


def test_numbers_that_nothing_holds_are_found_and_nothing_is_tried_in_vain(monkeypatch):
    values, asked = best(monkeypatch, [100.0, 100.0])
    assert np.sum((ALIKE @ (values - FREE)) ** 2) < 0.5  # no more is to be gained
    assert asked <= 4


def test_beside_a_bound_the_best_within_it_is_found(monkeypatch):
    """The step to the best of all is cut off by the bound, and would lose: a shorter one gains."""
    values, _ = best(monkeypatch, [0.1, 100.0])
    rest = ALIKE @ FREE - ALIKE[:, 0] * 0.1
    assert values == pytest.approx([0.1, ALIKE[:, 1] @ rest / (ALIKE[:, 1] @ ALIKE[:, 1])], abs=0.02)

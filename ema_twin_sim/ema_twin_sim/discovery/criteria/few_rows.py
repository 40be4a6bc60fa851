"""Few rows: a wave over a shaft angle that acts on hardly any of them is two numbers that fit these."""

from __future__ import annotations

from ...criteria import FEWEST_ROWS
from ...effects import catalogue
from ...identification.equation import EquationErrorProblem
from ...identification.fit import Fit


def shows_in_few_rows(problem: EquationErrorProblem, f: Fit, name: str) -> bool:
    """Whether an added effect over a shaft angle acts on fewer rows than tell a mean square well.

    Smoothing hides a fine wave but where the machine starts and reverses. Counted is the effective number of rows,
    which is that of all rows if an effect acts on all alike. Not tested for operating points, each of which tells by
    itself.
    """
    effect = catalogue()[f.hypothesis.added[name].effect]
    if effect.depends_on != "order" or not problem.size or any(o.of_points for o in problem.observations):
        return False
    power = f.slopes()[f"effects.{name}.{effect.parameters[0].name}"][: problem.size] ** 2
    squares = float(power @ power)
    return squares == 0.0 or float(power.sum() ** 2) < FEWEST_ROWS * squares

"""Few rows: a wave over a shaft angle that acts on hardly any of them is two numbers that fit these."""

from __future__ import annotations

import numpy as np

from ...criteria import DEPENDS, FEWEST_ROWS, SMALL
from ...effects import catalogue
from ...identification.equation import EquationErrorProblem
from ...identification.fit import Fit, fit
from .worth import noise_per_unit


def shows_in_few_rows(problem: EquationErrorProblem, f: Fit, name: str) -> bool:
    """Whether an added effect over a shaft angle acts on few rows, without explaining several places of a recording.

    Smoothing hides a fine wave but where the machine starts and reverses. Any two numbers fit the rows of one such
    place; those of others they fit only if the wave is there, and then nothing is left of them. Few are fewer than tell
    a mean square well, in the effective number of rows, which is that of all rows if an effect acts on all alike. Not
    tested for operating points, each of which tells by itself.
    """
    effect = catalogue()[f.hypothesis.added[name].effect]
    if effect.depends_on != "order" or not problem.size or any(o.of_points for o in problem.observations):
        return False
    power = f.slopes()[f"effects.{name}.{effect.parameters[0].name}"][: problem.size] ** 2
    squares = float(power @ power)
    if squares == 0.0:
        return True
    return float(power.sum() ** 2) < FEWEST_ROWS * squares and not _explains_several_places(problem, f, name)


def _explains_several_places(problem: EquationErrorProblem, f: Fit, name: str) -> bool:
    """Whether an effect gains outside the place where it gains most, and leaves hardly anything of all its places.

    Eight hidden waves left 5 % or less there; waves that imitate how friction turns round left 11 % to 66 %.
    """
    without = fit(problem, f.hypothesis.without(name), 4, known=f)
    before, after = (problem.costs(one.raw)[: problem.size] for one in (without, f))
    places = _places(problem, f, name)
    gained = (before - after) / noise_per_unit(without, f)[0]
    elsewhere = gained.sum() - max((gained[place].sum() for place in places), default=0.0)
    there, left = (sum(float(costs[place].sum()) for place in places) for costs in (before, after))
    return bool(elsewhere > DEPENDS and left < SMALL * there)


def _places(problem: EquationErrorProblem, f: Fit, name: str) -> list[slice]:
    """Runs of torque rows on which an effect acts by more than its mean: one for each start or reversal.

    Its action is told by its envelope, over all of its parameters: a wave passes through zero within a place too.
    """
    slopes = f.slopes()
    own = [slopes[path][: problem.size] for path in slopes if path.startswith(f"effects.{name}.")]
    power = np.sum([(rows / max(float(np.abs(rows).max()), np.finfo(float).tiny)) ** 2 for rows in own], axis=0)
    acts = power > power.mean()
    runs = []
    for part in problem.torque_parts:
        edges = np.flatnonzero(np.diff(np.r_[False, acts[part], False]))
        runs += [slice(part.start + int(a), part.start + int(b)) for a, b in edges.reshape(-1, 2)]
    return runs

"""Likeness: whether another dependence in an effect's place leaves nothing, while the effect clearly leaves something.

Over a small angle, gravity looks like a constant load to a few per cent, and a spring looks like gravity. The residual
of such a look-alike may be below the noise, but it has the shape of the true cause. A basis over the true quantity, in
place of the effect, explains both what the effect does and this residual; with it the effect is needless.
"""

from __future__ import annotations

from ...criteria import DEPENDS, LEAST_SIZE, MISFIT_DOUBTED, SMALL
from ...identification.comparable import by_chance, refuse_different_weightings
from ...identification.equation import EquationErrorProblem
from ...identification.fit import Fit, fit
from ...identification.generic_bases import dependence, fit_with_basis, load_bases
from ...identification.screening import screen_generic_bases
from .explained import coarse
from .worth import ENCODER_ONLY, largest_rms_reduction, penalised_gain


def likenesses(problem: EquationErrorProblem, f: Fit) -> tuple[str, ...]:
    """The added effects that only imitate a dependence on something, tested with the problem's generic bases.

    Empty with backlash or compliance, for which there is no basis, and if the current is coarse.
    """
    if f.parted or coarse(problem):
        return ()
    torques = [name for name, instance in f.hypothesis.added.items() if instance.effect not in ENCODER_ONLY]
    return tuple(name for name in torques if _better_instead(problem, f, name))


def _better_instead(problem: EquationErrorProblem, f: Fit, name: str) -> bool:
    """Whether another basis in an effect's place leaves nothing, gains more than chance, and makes the effect needless.

    It is the best-fitting basis. What the effect leaves must be more than a small part of what it does: on a real
    machine, whose friction follows no law exactly, a model of the right cause has such an error as well.
    """
    bare = fit(problem, f.hypothesis.without(name), 6, known=f)
    beside = problem.with_generic_bases({**problem.generic_bases, **load_bases(problem, bare)})
    basis = next((found for _, found in screen_generic_bases(beside, bare)), None)
    if basis is None:
        return False
    instead = fit_with_basis(beside, bare, basis)
    refuse_different_weightings(instead, f)
    if dependence(basis) == "load" and largest_rms_reduction(problem, f, instead) < LEAST_SIZE:
        return False  # as in ``explained.depends``: the load is known no better
    more = len(instead.hypothesis.free) - len(f.hypothesis.free)
    gained = (f.misfits[0] - instead.misfits[0]) / instead.variance_inflations[0] - by_chance(more)
    if instead.misfits[0] > MISFIT_DOUBTED * instead.judged[0] or gained <= DEPENDS:
        return False
    if f.misfits[0] - instead.misfits[0] < SMALL**2 * (bare.misfits[0] - f.misfits[0]):
        return False
    return penalised_gain(instead, fit_with_basis(beside, f, basis)) <= 0.0

"""One recording: it alone must tell an effect from chance, and from friction that wanders.

With several, an effect explains each of them with the same numbers, which neither does.
"""

from __future__ import annotations

from collections.abc import Callable

from ...criteria import DEPENDS, TOLERANCE
from ...effects import catalogue
from ...identification.fit import fit
from ...identification.wander import Wander
from ...identification.wandering import wandering
from ..criteria.worth import ENCODER_ONLY, NOTHING_ELSE, penalised_gain, standing_on
from .adding import less_each, prune, without_effect
from .removing import less, significant
from .search import torque_cost
from .trace import BY_CHANCE, WANDERS_IN_ONE, Search
from .wandering_end import with_wander


def less_what_one_recording_leaves_open(found: Search, progress: Callable[[str], None]) -> Search:
    """The search of one recording, without effects that chance or wandering friction explains as well.

    In one recording everything has happened once: what depends on the place, the speed or the temperature may as well
    depend on the time. Unchanged with several recordings.
    """
    told = [o for o in found.problem.observations if len(o.rows)]
    if len(told) != 1 or told[0].of_points:  # operating points have no time, and no second recording
        return found
    while (instead := _wandering_instead(found)) is not None:
        name, wander = instead
        progress(f"friction seems to vary slowly by {wander.share:.1%}: that explains as much as {name}")
        beside = with_wander(less(found, [name], WANDERS_IN_ONE).fit, wander)
        found = significant(found.ended(prune(beside), WANDERS_IN_ONE))
    while (least := _least_told(found)) is not None:
        found = significant(less(found, [least], BY_CHANCE))
    return found


def _wandering_instead(found: Search) -> tuple[str, Wander] | None:
    """The added effect that wandering friction replaces best, at hardly any more cost, and how it wanders then.

    By no more than the tolerance of a model file's constants: friction that stays within it is still that of the file.
    Beside it, the effect must gain no more than chance does: friction may wander and the effect be there.
    """
    f = found.fit
    if f.problem.weighting.wander is not None or f.parted:
        return None
    likely: list[tuple[float, str, Wander]] = []
    for name, held in f.hypothesis.added.items():
        if held.effect in ENCODER_ONLY or standing_on(f.hypothesis, name):
            continue
        bare = fit(f.problem, without_effect(f.hypothesis, name))
        for wander in (wandering(f.problem, bare), wandering(f.problem, bare, drifts=True)):
            if wander is None or wander.share > TOLERANCE:
                continue
            beside = with_wander(bare, wander)
            cost = torque_cost(beside) + wander.complexity_penalty
            if cost > torque_cost(f) + DEPENDS:
                continue
            if penalised_gain(beside, fit(beside.problem, f.hypothesis)) <= DEPENDS:  # no more than chance does
                likely.append((cost, name, wander))
    least = min(likely, key=lambda one: one[0], default=None)
    return None if least is None else least[1:]


def _least_told(found: Search) -> str | None:
    """The added effect that gains least, if no more than the residual of a right model gains from some dependence.

    Constants that are off their file have gained more than the rows show. Beside impacts, no effect alone tells what it
    gains.
    """
    f = found.fit
    over = {name: catalogue()[held.effect].depends_on for name, held in f.hypothesis.added.items()}
    names = [n for n in over if over[n] not in NOTHING_ELSE and not standing_on(f.hypothesis, n)]
    if f.parted or not names:
        return None
    gains = {n: penalised_gain(bare, f) for n, bare in zip(names, less_each(f, names), strict=True)}
    least = min(gains, key=gains.__getitem__)
    return least if gains[least] <= DEPENDS else None

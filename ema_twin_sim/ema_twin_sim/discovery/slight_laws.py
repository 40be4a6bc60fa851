"""Corrections over speed, or along a way, that are too slight to be named of a machine whose constants are open."""

from __future__ import annotations

import numpy as np

from ..criteria import SMALL
from ..effects import Trait, catalogue
from ..model.own_units import is_linear
from .idle_effects import shows_over
from .search.removing import less
from .search.trace import Search, new_names
from .unseen import Judge, Unseen

REASON = f"no law of friction is as exact as what it removes: less than {SMALL * SMALL:.0%} of the drive's torque"
ALONG = f"along a way something repeats by chance, and it removes less than {SMALL * SMALL:.0%} of the drive's force"


def without_slight_laws(found: Search, unseen: Unseen, judge: Judge, torque: float) -> tuple[Search, Unseen]:
    """The search without effects over speed that remove less than 1 % of the drive's rms ``torque`` [N m].

    Of a linear machine, waves along its way as well: a shaft repeats with its turns, while a way has no length by which
    it must. With open constants up to a tenth of the torque (SMALL) counts as nothing missing, since laws of friction
    are never exact; what removes less than a tenth of that only corrects the law. The effect that removes least goes
    first, unless without it the power of the error grows by as much. What is left is as small as before: the verdict
    stands.
    """
    if unseen.signal != "unexplained_torque":
        return found, unseen
    least = (SMALL * SMALL * torque) ** 2
    needed: set[str] = set()
    while True:
        slight = {name: gone for name, gone in _removed(found, unseen).items() if gone < least and name not in needed}
        if not slight:
            return found, unseen
        name = min(slight, key=slight.__getitem__)
        fewer = less(found, (name,), REASON if shows_over(found, name) == "speed" else ALONG)
        beside = judge(fewer)
        only_less = fewer.fit.hypothesis.added.keys() < found.fit.hypothesis.added.keys()  # no beaten rival came back
        grown = (beside.moving[-1] ** 2 - unseen.moving[-1] ** 2, beside.settled[-1] ** 2 - unseen.settled[-1] ** 2)
        if only_less and max(grown) < least:
            found, unseen = fewer, beside
        else:
            needed.add(name)


def _removed(found: Search, unseen: Unseen) -> dict[str, float]:
    """By effect that may be slight: the power [N² m²] of the error that its round removed, in motion.

    With or without what filters carry on from standstill, whichever shows more: it may hide the effect.
    """
    added = found.fit.hypothesis.added
    doubtful = {"speed", "order"} if is_linear(found.fit.hypothesis.base) else {"speed"}
    moving = np.diff(np.square((unseen.judged_from, *unseen.moving[1:])))
    settled = np.diff(np.square(unseen.settled))
    return {
        name: float(gone)
        for turn, gone in zip(found.taken, np.maximum(-moving, -settled), strict=False)
        for name in new_names(turn.before, turn.after)
        if name in added
        and shows_over(found, name) in doubtful
        and Trait.BRISTLE not in catalogue()[added[name].effect].traits
    }

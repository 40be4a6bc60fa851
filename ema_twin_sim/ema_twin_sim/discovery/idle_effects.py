"""Idle effects: those at the end of a search that the simulation of held-out recordings does not support."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from ..criteria import DEPENDS, NEGLIGIBLE, NOISY, PART
from ..effects import catalogue
from ..identification.fit import Fit, fit
from ..identification.hypothesis import COMPLIANT_EFFECTS
from ..identification.unseen_encoders import parting_explained_where_unseen
from ..model.roles import BRISTLE
from .criteria.worth import ENCODER_ONLY
from .search.trace import SWAPS, Search, new_names
from .unseen import Unseen


def idle_effects(found: Search, unseen: Unseen, kept: Collection[frozenset[str]] = ()) -> tuple[tuple[str, ...], bool]:
    """Effects at the end of the search that simulation of held-out recordings does not support.

    * Backlash or compliance that the encoders suggest but that removes little of the error there. In a loop with known
      constants it must remove more than it leaves: play and a shaft that winds up look alike to slow encoders.
    * An error of an encoder that removes little of the output's error there, with known constants and rigid teeth,
      unless recordings that it was not fitted to show it between the encoders, since a simulated output drifts. In one
      recording nothing tells it from a gearbox that rings, or gives way by less than can be named.
    * A bristle that removes nothing there, since it acts only in the first moments of a motion.
    * With open constants: any effect on the torque that removes nothing there, or beside the noise adds to the error;
      and all that came after an error which was smaller than that of the end.

    Sets that were ``kept``, because the simulation is worse without them, are not named again. Several effects may need
    each other and be worse together than none of them. Second, whether it is backlash or compliance.
    """
    added = found.fit.hypothesis.added
    needed = frozenset[str]().union(*kept)
    real = found.fit.hypothesis.base.is_open
    for k, turn in enumerate(found.taken):
        came = [name for name in new_names(turn.before, turn.after) if name in added and name not in needed]
        parting = tuple(name for name in came if added[name].effect in COMPLIANT_EFFECTS)
        bending = tuple(name for name in came if added[name].effect == BRISTLE)
        first, ended = _judged_over(found, unseen, k)
        if errors := _encoder_errors(found, unseen, k):
            return errors, False
        of_torque = real and bool(came) and any(shows_over(found, name) != "encoders" for name in came)
        if unseen.moving[k] <= NOISY * unseen.noise_floor:
            if of_torque and unseen.moving[ended] > (1.0 + NEGLIGIBLE) * unseen.moving[first]:
                return tuple(came), False
            continue
        removed = unseen.removed(first, len(unseen.moving) - 1)
        # A measured current drives no loop that would reach the teeth, and a hunting loop hides them: use the output.
        followed = unseen.output_removed(first, len(unseen.moving) - 1) >= PART
        little = removed is not None and removed < PART and not followed
        another = not real and unseen.signal != "unexplained_torque" and unseen.mostly_left(first)
        if parting and (little or another):
            return parting, True
        there = unseen.removed(first, ended)
        nothing = there is not None and there <= 0.0 and not (real and unseen.clearly_less(first, ended))
        if of_torque and nothing:
            return tuple(came), False
        if bending and nothing:
            return bending, False
    return (_since_the_best(found, unseen, kept) if real else ()), False


def idle_encoder_errors(found: Search, unseen: Unseen) -> tuple[str, ...]:
    """The idle errors of encoders alone. Something unknown beside them is no reason to keep them."""
    return next((names for k in range(len(found.taken)) if (names := _encoder_errors(found, unseen, k))), ())


def _encoder_errors(found: Search, unseen: Unseen, k: int) -> tuple[str, ...]:
    """Errors of an encoder that came with round ``k`` and removed little of the output's error."""
    turn, f = found.taken[k], found.fit
    added = f.hypothesis.added
    came = tuple(n for n in new_names(turn.before, turn.after) if n in added and added[n].effect in ENCODER_ONLY)
    if not came or f.hypothesis.base.is_open or f.parted or not unseen.output:
        return ()
    shown = unseen.output_removed(*_judged_over(found, unseen, k)) >= PART or _other_recordings_show(f, came)
    return () if shown else came


def _other_recordings_show(f: Fit, errors: Collection[str]) -> bool:
    """Whether the errors of an encoder explain most recordings with the size that the others tell, beyond chance."""
    if len(f.problem.observations) < 2:
        return False
    gained = parting_explained_where_unseen(fit(f.problem, f.hypothesis.without(*errors), known=f), f)
    return bool(gained.sum() > DEPENDS and np.count_nonzero(gained > 0.0) > 0.5 * len(gained))


def _since_the_best(found: Search, unseen: Unseen, kept: Collection[frozenset[str]]) -> tuple[str, ...]:
    """Effects on the torque that came after the round that left the smallest error, if the end leaves clearly more."""
    added = found.fit.hypothesis.added
    held = [{*found.rounds[0].before.hypothesis.added}, *({*turn.after.hypothesis.added} for turn in found.taken)]
    # the end may be one more
    errors = [(unseen.moving[k], k, before) for k, before in enumerate(held[: len(unseen.moving)])]
    least, best, before = min((one for one in errors if one[2] <= {*added}), key=lambda one: one[0])
    if not unseen.moving[-1] > (1.0 + NEGLIGIBLE) * least or unseen.clearly_less(best, -1):
        return ()
    since = tuple(n for n in added if n not in before and shows_over(found, n) != "encoders")
    return () if frozenset(since) in kept else since


def _judged_over(found: Search, unseen: Unseen, k: int) -> tuple[int, int]:
    """The round before the effects of round ``k``, and the round that shows what they do: their own, or the last."""
    first = _before_both(found, k)
    return first, k + 1 if first == k else len(unseen.moving) - 1


def _before_both(found: Search, k: int) -> int:
    """First round at which neither the effects of round ``k`` nor the effects they replaced were present.

    A rival need not be better than the effect it replaces, in this round, or in a later one that only removed: then the
    place was given up for what is there.
    """
    swaps = [
        turn
        for turn in found.taken[k:]
        if turn.reason in SWAPS and (turn is found.taken[k] or not new_names(turn.before, turn.after))
    ]
    gone = {name for turn in swaps for name in new_names(turn.after, turn.before)}
    return next((j for j, earlier in enumerate(found.taken[:k]) if not gone.isdisjoint(earlier.added)), k)


def shows_over(found: Search, name: str) -> str:
    """The quantity that an effect depends on."""
    return catalogue()[found.fit.hypothesis.added[name].effect].depends_on

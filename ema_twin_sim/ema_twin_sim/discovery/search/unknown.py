"""Unknown: the residual depends on something, but no effect of the catalogue explains it."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ...criteria import MOSTLY, RIVAL_MARGIN
from ...effects import Trait, catalogue, effects_with
from ...identification.equation import EquationErrorProblem
from ...identification.fit import Fit, fit
from ...identification.generic_bases import beside_generic_bases, dependence, fit_with_basis, order_bases
from ...identification.hypothesis import COMPLIANT_EFFECTS
from ...identification.screening import screen_generic_bases
from ..criteria.episodes import episodes
from ..criteria.explained import apart
from ..criteria.likeness import likenesses
from ..criteria.opposed_loads import opposed
from ..criteria.own_shape import (
    by_own_shape,
    explains_the_torque,
    follows_laws,
    hardly_part,
    imitates,
    is_play,
    only_teeth,
    parts_the_encoders,
    shape_over,
)
from ..criteria.plausible import only_constants, strained
from ..criteria.worth import BY_CONSTANTS, NOTHING_ELSE, is_lacked
from .adding import add_best
from .found_orders import is_bend
from .removing import less, significant, with_what_made_room
from .rivals import came_near, substitutes, swapped
from .trace import Round, Search, new_names
from .wandering_end import beside_wandering

MOST_ROUNDS = 4  # an unknown cause shows in the first rounds
LIKENESS = "it may only look like the unknown cause"
Held = frozenset[tuple[object, ...]]
TRIED = 2  # bases that are fitted in a round


def beside_the_unknown(found: Search, progress: Callable[[str], None]) -> tuple[Search, tuple[str, ...]]:
    """Which effects of a search hold up next to an unknown cause, and what that cause depends on.

    An effect holds up if its own shape explains what any shape over its quantity would, and if nothing in its place
    explains more. The others may only imitate the unknown cause, and so may what made constants implausible.
    """
    if not found.problem.size:  # no torque was measured that could depend on anything
        return found, ("encoders",)
    start = found.rounds[0].before
    if found.fit.hypothesis.base.is_open:  # nothing contradicts open constants
        found = less(found, [n for n in found.fit.hypothesis.added if is_bend(found.problem, found.fit, n)], LIKENESS)
        while name := opposed(found.fit) or _of_the_same_cause(found):
            found = less(found, [name], LIKENESS)
        problem = beside_generic_bases(found.problem, found.fit)
        between = ("encoders",) if apart(problem, found.fit, start) else ()
        return found, tuple(dict.fromkeys((*_most_likely(problem, found.fit), *between)))
    found = doubted(found)
    known = {catalogue()[effect].depends_on for effect in found.fit.hypothesis.effects}
    every = beside_generic_bases(found.problem, found.fit).generic_bases
    bases: Mapping[str, np.ndarray] = {
        name: columns for name, columns in every.items() if dependence(name) not in known
    }
    after, rounds, bases = _add_dependences(found.fit, bases, progress)
    held = {*found.fit.hypothesis.added}
    beside = significant(found.further(after, rounds))
    spanned = _explains_most(found, after, held - {*beside.fit.hypothesis.added})
    # several bases together span almost any effect, which is no reason to prefer them to one that does it alone
    told = after if spanned else beside.fit
    found = found if spanned else beside
    if came := {*found.fit.hypothesis.added} - held:  # in place of an uncertain one; not checked yet
        found = less(found, [name for name in _doubtful(_without_dependences(found)) if name in came], LIKENESS)
    problem = found.problem.with_generic_bases(bases)
    depends_on = tuple(dict.fromkeys(dependence(name) for name in told.hypothesis.generic_bases))
    suspect = {*depends_on, *strained(found.fit), *(["encoders"] if apart(problem, found.fit, start) else [])}
    # to a fit, something that comes and goes is an outlier and no lasting dependence
    passing = ("time",) if not suspect and episodes(problem, found.fit) else ()
    return found, depends_on or tuple(sorted(suspect)) or passing or _most_likely(problem, found.fit)


def _of_the_same_cause(found: Search) -> str | None:
    """The last added effect over the quantity that the rest depends on, if another shape over it explains much more."""
    problem, added = beside_generic_bases(found.problem, found.fit), found.fit.hypothesis.added
    left = _most_likely(problem, found.fit)
    over = [name for name in added if shape_over(found.fit, name) in left]
    return next((name for name in reversed(over) if imitates(problem, found.fit, name)), None)


def _explains_most(found: Search, after: Fit, names: Collection[str]) -> bool:
    """Whether one of these effects explains most of the torque that all effects and bases of a later fit explain."""
    if not names:
        return False
    h = found.fit.hypothesis
    most = MOSTLY * (fit(found.problem, h.without(*h.added)).misfits[0] - after.misfits[0])
    without = (fit(found.problem, h.without(name)).misfits[0] for name in names)
    return most > 0.0 and any(misfit - found.fit.misfits[0] >= most for misfit in without)


def _add_dependences(
    current: Fit, bases: Mapping[str, np.ndarray], progress: Callable[[str], None]
) -> tuple[Fit, list[Round], Mapping[str, np.ndarray]]:
    """Add one generic basis a round until none is worth its penalty; return the end, the rounds and all bases tried.

    Each round also tries the orders that are strongest in its residual.
    """
    tried = dict(bases)

    def entering(current: Fit, excluded: frozenset[str]) -> list[Fit]:
        progress("looking for what the remaining error depends on")
        tried.update(order_bases(current.problem, current))
        problem = current.problem.with_generic_bases({**tried})
        names = [name for _, name in screen_generic_bases(problem, current) if name not in excluded][:TRIED]
        return [fit_with_basis(problem, current, name) for name in names]

    after, rounds = add_best(current, entering, MOST_ROUNDS, progress)
    return after, rounds, tried


def _without_dependences(found: Search) -> Search:
    """The search, its end fitted without generic bases."""
    return replace(found, fit=fit(found.problem, found.fit.hypothesis.without_generic_bases()))


def doubted(found: Search) -> Search:
    """The search without the effects that may only imitate an unknown cause.

    What had been removed for their sake is tried again, and doubted in turn. What was close to a doubtful effect in its
    round is tried first in its place.
    """
    tried = [_held(found.fit)]
    while names := _doubtful(found):
        other = next((other for name in names if (other := _instead(found, name, tried)) is not None), None)
        found = with_what_made_room(less(found, names, LIKENESS)) if other is None else other
        tried.append(_held(found.fit))
    return found


def _held(f: Fit) -> Held:
    """The added effects with their options, in no order."""
    return frozenset((held.effect, *sorted(held.options.items())) for held in f.hypothesis.added.values())


def _instead(found: Search, name: str, tried: Sequence[Held]) -> Search | None:
    """Replace a doubtful effect by one that was close in its round and holds up where it does not; None if none does.

    It does not lead back to effects that were ``tried``: of two that are nearly equal, each may look surer where the
    other stands. It either explained as much, or is one that every machine has and this model lacks: friction that
    warms up may look a little more like another friction than like dry friction alone.
    """
    turn = next((turn for turn in found.taken if name in turn.added), None)
    if turn is None:
        return None
    as_much = max((trial.gain for trial in turn.tried if name in trial.names), default=math.inf) - RIVAL_MARGIN
    equal = {effect for effect, _ in came_near(found.fit.hypothesis, name, turn, as_much)}
    for other in substitutes(found.fit, name, turn):
        came = new_names(found.fit, other)
        effects = {other.hypothesis.added[n].effect for n in came}
        if effects <= equal or all(is_lacked(other.hypothesis, effect) for effect in effects):
            instead = swapped(found, other)
            if _held(instead.fit) in tried:
                continue
            if {*came} <= {*instead.fit.hypothesis.added} and {*came}.isdisjoint(_doubtful(instead)):
                return replace(instead, rounds=(*found.rounds, replace(instead.rounds[-1], reason=LIKENESS)))
    return None


def _doubtful(found: Search) -> list[str]:
    """The added effects that do not hold up next to an unknown cause."""
    problem = beside_generic_bases(found.problem, found.fit)
    added = found.fit.hypothesis.added
    over = {name: catalogue()[instance.effect].depends_on for name, instance in added.items()}
    lags = apart(problem, found.fit, found.rounds[0].before)
    own = set(by_own_shape(problem, found.fit))
    # An output that lags affects inertia and friction, as it does in a search by torque alone.
    like_lag = effects_with(Trait.LIKE_PLAY_OR_SPRING) if lags else frozenset()
    drawn = {n for n in added if added[n].effect in like_lag and not explains_the_torque(found.fit, n)}
    if drawn and _has_gearbox(problem, found.fit):  # the lag is in the model: it draws no constant any more, and
        # no effect either where hardly any of it is left
        drawn -= {name for name in drawn if over[name] in NOTHING_ELSE or hardly_part(found.fit)}
    if (own != {*added} or drawn) and (beside := beside_wandering(found)) is not None:
        # If each recording has its own speed, a basis over speed also fits what differs between recordings because
        # friction wanders. An effect that holds once the wandering is part of the noise is not doubted for that.
        own |= set(by_own_shape(beside_generic_bases(beside.problem, beside), beside, {*added} - own))
        drawn = {n for n in drawn if not explains_the_torque(beside, n)}
    stands = own - set(only_constants(problem, found.fit))
    stands -= set(likenesses(problem, found.fit))
    stands -= {name for name in stands if is_bend(problem, found.fit, name)}
    by_encoders = {name for name in added if over[name] == "encoders"} if lags else set()
    stands -= {name for name in by_encoders if not _explains(problem, found.fit, name)}
    stands -= {name for name in stands if is_play(found.fit, name) and only_teeth(problem, found.fit, name)}
    if not found.fit.parted and _gearbox_explains_more(found):
        stands -= {name for name in stands if catalogue()[added[name].effect].delays}
    if stands == {*added} and not drawn:  # otherwise a doubtful effect may have pulled the constants
        stands -= _straining(found, over)
    doubtful = [name for name in added if name not in stands]
    if {added[name].effect for name in doubtful}.isdisjoint(COMPLIANT_EFFECTS):
        return [name for name in added if name in doubtful or name in drawn]
    # Once a doubtful backlash or compliance is removed, the remaining encoder difference may be interpolation error.
    # Effects that it drew in are judged after its removal, and so is a late encoder, which shared the difference with
    # it.
    return [name for name in doubtful if not catalogue()[added[name].effect].delays]


def _straining(found: Search, over: Mapping[str, str]) -> set[str]:
    """The added effects that pull constants from the file's values; ``over`` tells what each depends on.

    An effect is not doubted if the same constants are off without it and friction follows no law exactly: that moves
    them as well. Where nothing but the sensors' noise is left, constants that are off show a wrong explanation.
    """
    strange = {*strained(found.fit)}
    if not strange:
        return set()
    h = found.fit.hypothesis
    by_constants = {name for name in h.added if over[name] in BY_CONSTANTS}
    usual = {name for name in by_constants if is_lacked(h, h.added[name].effect)}
    suspects = by_constants - usual or by_constants  # usual effects are judged once the others are gone
    if follows_laws(found.problem, found.fit):
        return suspects
    return {name for name in suspects if not strange <= {*strained(fit(found.problem, h.without(name)))}}


def _explains(problem: EquationErrorProblem, f: Fit, name: str) -> bool:
    """Whether backlash, compliance or an encoder error explains the encoder difference, or a compliance the torque.

    A gearbox that rings moves the motor: if the torque needs it, it is there, whatever else parts the encoders.
    """
    compliant = f.hypothesis.added[name].effect in COMPLIANT_EFFECTS and not is_play(f, name)
    return (compliant and explains_the_torque(f, name)) or parts_the_encoders(problem, f, name)


def _gearbox_explains_more(found: Search) -> bool:
    """Whether backlash or compliance, too small to be named, gained clearly more than a late encoder in some round.

    An output lags behind a gearbox that gives way as well.
    """
    for turn in found.rounds:
        added = [trial.fit.hypothesis.added for trial in turn.tried]
        taken = {held[n].effect for held in added for n in turn.added if n in held}
        if not taken.isdisjoint(COMPLIANT_EFFECTS):  # it was large enough, and is judged by itself
            continue
        late, gearbox = -math.inf, -math.inf
        for trial in turn.tried:
            came = {trial.fit.hypothesis.added[n].effect for n in trial.names if n in trial.fit.hypothesis.added}
            if any(catalogue()[id].delays for id in came):
                late = max(late, trial.gain)
            elif not came.isdisjoint(COMPLIANT_EFFECTS):
                gearbox = max(gearbox, trial.gain)
        if math.isfinite(late) and gearbox > late + RIVAL_MARGIN:
            return True
    return False


def _has_gearbox(problem: EquationErrorProblem, f: Fit) -> bool:
    """Whether the model has backlash or compliance, and all of it holds up."""
    gearbox = [name for name, instance in f.hypothesis.added.items() if instance.effect in COMPLIANT_EFFECTS]
    return bool(gearbox) and all(_explains(problem, f, name) for name in gearbox)


def _most_likely(problem: EquationErrorProblem, f: Fit) -> tuple[str, ...]:
    """The quantity that the residual depends on most, however little that explains."""
    return tuple(dependence(name) for _, name in screen_generic_bases(problem, f)[:1])

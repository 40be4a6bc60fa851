"""Unknown: what is left depends on something, though no effect of the catalogue explains it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from ...effects import Trait, catalogue, effects_with
from ...identification.equation import EquationErrorProblem
from ...identification.fit import Fit
from ...identification.generic_bases import beside_generic_bases, dependence, fit_with_basis, order_bases
from ...identification.hypothesis import COMPLIANT_EFFECTS
from ...identification.screening import screen_generic_bases
from ..criteria.episodes import episodes
from ..criteria.explained import apart
from ..criteria.likeness import likenesses
from ..criteria.own_shape import by_own_shape, explains_the_torque, is_play, only_teeth, parts_the_encoders
from ..criteria.plausible import only_constants, strained
from ..criteria.worth import BY_CONSTANTS, is_lacked
from .adding import add_best
from .removing import less, significant, with_what_made_room
from .rivals import substitutes, swapped
from .trace import Round, Search, new_names
from .wandering_end import beside_wandering

MOST_ROUNDS = 4  # what an unknown depends on shows in the first rounds
LIKENESS = "may be nothing but the likeness of what is unknown"
TRIED = 2  # bases that are fitted in a round


def beside_the_unknown(
    found: Search,
    progress: Callable[[str], None],
) -> tuple[Search, tuple[str, ...]]:
    """What of a search stands beside what is in no catalogue, and what that depends on.

    An effect stands that explains by its own shape what any shape over its quantity would, and in whose place nothing
    else explains more. The others may be nothing but the likeness of the unknown, as is what made constants
    implausible.
    """
    if not found.problem.size:  # no torque was measured that could depend on anything
        return found, ("encoders",)
    if found.fit.hypothesis.base.is_open:  # whose numbers nothing contradicts: what was found stays
        return found, _most_likely(beside_generic_bases(found.problem, found.fit), found.fit)
    start = found.rounds[0].before
    found = doubted(found)
    known = {catalogue()[effect].depends_on for effect in found.fit.hypothesis.effects}
    every = beside_generic_bases(found.problem, found.fit).generic_bases
    bases: Mapping[str, np.ndarray] = {
        name: columns for name, columns in every.items() if dependence(name) not in known
    }
    after, rounds, bases = _add_dependences(found.fit, bases, progress)
    held = {*found.fit.hypothesis.added}
    found = significant(found.further(after, rounds))
    # what comes back in the place of something too uncertain was not doubted yet
    found = less(found, [name for name in _doubtful(found) if name not in held], LIKENESS)
    problem = found.problem.with_generic_bases(bases)
    depends_on = tuple(dict.fromkeys(dependence(name) for name in found.fit.hypothesis.generic_bases))
    suspect = {*depends_on, *strained(found.fit), *(["encoders"] if apart(problem, found.fit, start) else [])}
    # what comes and goes is an outlier to a fit, and no lasting dependence
    passing = ("time",) if not suspect and episodes(problem, found.fit) else ()
    return found, depends_on or tuple(sorted(suspect)) or passing or _most_likely(problem, found.fit)


def _add_dependences(
    current: Fit, bases: Mapping[str, np.ndarray], progress: Callable[[str], None]
) -> tuple[Fit, list[Round], Mapping[str, np.ndarray]]:
    """One generic basis a round, until none is worth its price: the end, the rounds, and all bases that were tried.

    With each round go the orders that its residual shows most.
    """
    tried = dict(bases)

    def entering(current: Fit, excluded: frozenset[str]) -> list[Fit]:
        progress("asking what the rest depends on")
        tried.update(order_bases(current.problem, current))
        problem = current.problem.with_generic_bases({**tried})
        names = [name for _, name in screen_generic_bases(problem, current) if name not in excluded][:TRIED]
        return [fit_with_basis(problem, current, name) for name in names]

    after, rounds = add_best(current, entering, MOST_ROUNDS, progress)
    return after, rounds, tried


def doubted(found: Search) -> Search:
    """A search less the effects that may be nothing but the likeness of something unknown.

    What had made room for these comes back, and is doubted in turn. In the place of one goes first what every machine
    has and this model lacks, where that stands.
    """
    while names := _doubtful(found):
        usual = next((other for name in names if (other := _usual_instead(found, name)) is not None), None)
        found = with_what_made_room(less(found, names, LIKENESS)) if usual is None else usual
    return found


def _usual_instead(found: Search, name: str) -> Search | None:
    """The search with a doubtful effect's place taken by what every machine has and this model lacks; None without.

    It came near in the effect's round, and stands where that does not: friction that warms up is a little more like
    Stribeck's than like dry friction alone.
    """
    turn = next((turn for turn in found.taken if name in turn.added), None)
    for other in () if turn is None else substitutes(found.fit, name, turn):
        came = new_names(found.fit, other)
        if all(is_lacked(other.hypothesis, other.hypothesis.added[n].effect) for n in came):
            instead = swapped(found, other)
            if {*came} <= {*instead.fit.hypothesis.added} and {*came}.isdisjoint(_doubtful(instead)):
                return replace(instead, rounds=(*found.rounds, replace(instead.rounds[-1], reason=LIKENESS)))
    return None


def _doubtful(found: Search) -> list[str]:
    """The added effects that do not stand beside something unknown."""
    problem = beside_generic_bases(found.problem, found.fit)
    added = found.fit.hypothesis.added
    over = {name: catalogue()[instance.effect].depends_on for name, instance in added.items()}
    strange = strained(found.fit)
    lags = apart(problem, found.fit, found.rounds[0].before)
    own = set(by_own_shape(problem, found.fit))
    # what lets the output lag draws inertia and friction, as it does where the torque alone is looked at
    like_lag = effects_with(Trait.LIKE_PLAY_OR_SPRING) if lags else frozenset()
    drawn = {n for n in added if added[n].effect in like_lag and not explains_the_torque(found.fit, n)}
    if (own != {*added} or drawn) and (beside := beside_wandering(found)) is not None:
        # where each recording has a speed of its own, a basis over the speed takes up what wanders between them, too:
        # that, and what it leaves, is no reason to doubt what stands beside wandering
        own |= set(by_own_shape(beside_generic_bases(beside.problem, beside), beside, {*added} - own))
        drawn = {n for n in drawn if not explains_the_torque(beside, n)}
    stands = own - set(only_constants(problem, found.fit))
    stands -= set(likenesses(problem, found.fit))
    if strange:
        by_constants = {name for name in added if over[name] in BY_CONSTANTS}
        usual = {name for name in by_constants if is_lacked(found.fit.hypothesis, added[name].effect)}
        stands -= by_constants - usual or by_constants  # what every machine has is judged once the others are gone
    by_encoders = {name for name in added if over[name] == "encoders"} if lags else set()
    stands -= {name for name in by_encoders if not parts_the_encoders(problem, found.fit, name)}
    stands -= {name for name in stands if is_play(found.fit, name) and only_teeth(problem, found.fit, name)}
    doubtful = [name for name in added if name not in stands]
    if {added[name].effect for name in doubtful}.isdisjoint(COMPLIANT_EFFECTS):
        return [name for name in added if name in doubtful or name in drawn]
    # once a doubtful play or spring is gone, the encoders may part by no more than lines do: what is drawn by them is
    # judged without it, and so is a late encoder, of which it took a part
    return [name for name in doubtful if not catalogue()[added[name].effect].delays]


def _most_likely(problem: EquationErrorProblem, f: Fit) -> tuple[str, ...]:
    """What the residual depends on the most, however little that explains."""
    return tuple(dependence(name) for _, name in screen_generic_bases(problem, f)[:1])

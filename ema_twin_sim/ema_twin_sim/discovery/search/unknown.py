"""Unknown: what is left depends on something, though no effect of the catalogue explains it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from ...effects import catalogue
from ...identification.equation import EquationErrorProblem
from ...identification.fit import Fit
from ...identification.generic_bases import add_generic_bases, dependence
from ...identification.screening import screen_generic_bases
from ..criteria.episodes import episodes
from ..criteria.explained import apart
from ..criteria.own_shape import by_own_shape
from ..criteria.plausible import only_constants, strained
from ..criteria.worth import BY_CONSTANTS
from .search import add_effects, less, significant
from .trace import Search


def beside_the_unknown(
    problem: EquationErrorProblem,
    found: Search,
    progress: Callable[[str], None],
) -> tuple[Search, tuple[str, ...]]:
    """What of a search stands beside what is in no catalogue, and what that depends on.

    An effect stands that explains by its own shape what any shape over its quantity would. The others may be nothing
    but the likeness of the unknown, as is what made constants implausible.
    """
    if not problem.size:  # no torque was measured that could depend on anything
        return found, ("encoders",)
    add_generic_bases(problem)
    if found.fit.hypothesis.base.is_open:  # whose numbers nothing contradicts: what was found stays
        return found, _most_likely(problem, found.fit)
    start = found.rounds[0].before
    found = doubted(problem, found)
    progress("asking what the rest depends on")
    known = {catalogue()[effect].depends_on for effect in found.fit.hypothesis.effects}
    problem.generic_bases = {
        name: columns for name, columns in problem.generic_bases.items() if dependence(name) not in known
    }
    after, rounds = add_effects(problem, found.fit, frozenset(catalogue()), progress, with_bases=True)
    found = significant(
        problem, replace(found, fit=after, rounds=(*found.rounds, *rounds), weighting=problem.weighting)
    )
    depends_on = tuple(dict.fromkeys(dependence(name) for name in found.fit.hypothesis.generic_bases))
    suspect = {*depends_on, *strained(found.fit), *(["encoders"] if apart(problem, found.fit, start) else [])}
    # what comes and goes is an outlier to a fit, and no lasting dependence
    passing = ("time",) if not suspect and episodes(problem, found.fit) else ()
    return found, depends_on or tuple(sorted(suspect)) or passing or _most_likely(problem, found.fit)


def doubted(problem: EquationErrorProblem, found: Search) -> Search:
    """A search less the effects that may be nothing but the likeness of something unknown."""
    add_generic_bases(problem)
    added = found.fit.hypothesis.added
    over = {name: catalogue()[instance.effect].depends_on for name, instance in added.items()}
    strange = strained(found.fit)
    lags = apart(problem, found.fit, found.rounds[0].before)
    stands = set(by_own_shape(problem, found.fit)) - set(only_constants(problem, found.fit))
    stands -= {name for name in added if strange and over[name] in BY_CONSTANTS}
    stands -= {name for name in added if lags and over[name] == "encoders"}
    reason = "may be nothing but the likeness of what is unknown"
    return less(problem, found, [name for name in added if name not in stands], reason)


def _most_likely(problem: EquationErrorProblem, f: Fit) -> tuple[str, ...]:
    """What the residual depends on the most, however little that explains."""
    return tuple(dependence(name) for _, name in screen_generic_bases(problem, f)[:1])

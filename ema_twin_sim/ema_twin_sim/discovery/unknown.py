"""Unknown: what is left depends on something, though no effect of the catalogue explains it."""

from __future__ import annotations

from collections.abc import Callable

from ..effects import catalogue
from .decoys import add_decoys, dependence
from .episodes import episodes
from .equation import Equation
from .explained import apart
from .fit import Fit
from .hypothesis import Hypothesis
from .plausible import only_constants, strained
from .screening import screen_decoys
from .search import less, search
from .trace import Search
from .worth import BY_CONSTANTS


def beside_the_unknown(
    eq: Equation,
    null: Hypothesis,
    barred: frozenset[str],
    found: Search,
    progress: Callable[[str], None],
) -> tuple[Search, tuple[str, ...]]:
    """A search in which what is in no catalogue may stand beside the effects, and what that depends on.

    Only what was found before may stay: in company anything fits. And not what shows over the very quantity that the
    unknown depends on, or what made constants implausible: it may be nothing but the unknown's likeness.
    """
    add_decoys(eq)
    if null.base.is_open:  # whose numbers nothing contradicts: what was found stays, however much is left beside it
        return found, _most_likely(eq, found.fit)
    start = found.rounds[0].before
    suspect = set(BY_CONSTANTS if strained(found.fit) else ())
    likenesses = {found.fit.hypothesis.added[name].effect for name in only_constants(eq, found.fit)}
    kept = {id for id in found.fit.hypothesis.effects if catalogue()[id].depends_on not in suspect} - likenesses
    found = search(eq, null, barred | (set(catalogue()) - kept), progress, found.fit)
    depends_on = tuple(dict.fromkeys(dependence(name) for name in found.fit.hypothesis.decoys))
    suspect = {*depends_on, *strained(found.fit), *(["encoders"] if apart(eq, found.fit, start) else [])}
    added = found.fit.hypothesis.added
    alike = [name for name, instance in added.items() if catalogue()[instance.effect].depends_on in suspect]
    reason = "may be nothing but the likeness of what is unknown"
    found = less(eq, found, alike, reason)
    # what comes and goes is an outlier to a fit, and no lasting dependence
    passing = ("time",) if not suspect and episodes(eq, found.fit) else ()
    return found, depends_on or tuple(sorted(suspect)) or passing or _most_likely(eq, found.fit)


def _most_likely(eq: Equation, f: Fit) -> tuple[str, ...]:
    """What the residual depends on the most, however little that explains."""
    return tuple(dependence(name) for _, name in screen_decoys(eq, f)[:1])

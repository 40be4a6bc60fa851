"""Laws: the form of an effect's equation that explains most beside the other effects.

A round that adds an effect compares the forms beside what is still missing then, which may favour the wrong one; the
wrong form leaves a remainder, for which a search would take further effects.
"""

from __future__ import annotations

from ...effects import catalogue
from ...identification.fit import Fit, fit
from ..criteria.worth import penalised_gain
from .trace import Search


def with_best_laws(f: Fit) -> Fit:
    """A fit with each added effect under the law of its equation that explains most; the same one if it has these."""
    for name, held in f.hypothesis.added.items():
        effect = catalogue()[held.effect]
        for law in effect.options[effect.law] if effect.law else ():
            instance = f.hypothesis.instance(name)
            if law == instance.options[effect.law]:
                continue
            options = {**instance.options, effect.law: law}
            rival = fit(f.problem, f.hypothesis.without(name).with_effect(effect.id, options, instance.parameters))
            if penalised_gain(f, rival) > 0.0:
                f = rival
    return f


def under_best_laws(found: Search) -> Search:
    """The search with each added effect at its end under the law that explains most."""
    best = with_best_laws(found.fit)
    return found if best is found.fit else found.refitted(best)

"""Laws: the form of an effect's equation that explains most, once all other effects are there.

A round compares the forms beside what is still missing then, which may favour the wrong one.
"""

from __future__ import annotations

from ...effects import catalogue
from ...identification.fit import fit
from ..criteria.worth import penalised_gain
from .trace import Search


def under_best_laws(found: Search) -> Search:
    """The search with each added effect under the law of its equation that explains most."""
    for name, held in found.fit.hypothesis.added.items():
        effect = catalogue()[held.effect]
        for law in effect.options[effect.law] if effect.law else ():
            h = found.fit.hypothesis
            instance = h.instance(name)
            if law == instance.options[effect.law]:
                continue
            under = h.without(name).with_effect(effect.id, {**instance.options, effect.law: law}, instance.parameters)
            rival = fit(found.problem, under)
            if penalised_gain(found.fit, rival) > 0.0:
                found = found.refitted(rival)
    return found

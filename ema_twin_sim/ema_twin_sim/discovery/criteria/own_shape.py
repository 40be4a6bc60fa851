"""Own shape: whether an effect explains what any dependence on the same quantity would, beside something unknown.

Where something is left that no effect explains, an effect that was found may be nothing but its likeness: a bump of
friction over the speed looks like Stribeck's. Then a basis of any shape over that quantity explains much more than the
effect does. Where the effect's own shape explains what the basis explains, it is that effect, whatever else is left.
"""

from __future__ import annotations

import numpy as np

from ...effects import catalogue
from ...identification.equation import Equation
from ...identification.fit import Fit, fit
from ...identification.generic_bases import dependence, order_decoys
from ...identification.screening import screen_decoys

TELLING = 0.03  # of the noise's variance: what an effect must take away for its shape to tell anything
OWN_SHARE = 0.98  # of the misfit that the best basis takes away, which an effect must take away


def by_own_shape(eq: Equation, f: Fit) -> tuple[str, ...]:
    """The added effects that explain what they do by their own shape; also those over what there is no basis for."""
    return tuple(name for name in f.hypothesis.added if _own(eq, f, name))


def _own(eq: Equation, f: Fit, name: str) -> bool:
    over = catalogue()[f.hypothesis.added[name].effect].depends_on
    bare = fit(eq, f.hypothesis.without(name), 6, known=f)
    kept = eq.decoys
    try:
        eq.decoys = _over(eq, bare, over)
        if not eq.decoys:  # of what shows over this, there is no other shape
            return True
        took = bare.misfit - f.misfit
        if took < TELLING * f.judged:
            return False
        best = next((found for _, found in screen_decoys(eq, bare)), None)
        if best is None:
            return True
        any_shape = fit(eq, bare.hypothesis.with_decoy(best, eq.decoys[best].shape[1]), 3, known=bare)
        return took >= OWN_SHARE * (bare.misfit - any_shape.misfit)
    finally:
        eq.decoys = kept


def _over(eq: Equation, bare: Fit, over: str) -> dict[str, np.ndarray]:
    """The bases over a quantity; over the time one for all recordings together."""
    if over == "order":
        return order_decoys(eq, bare)
    found = {name: columns for name, columns in eq.decoys.items() if dependence(name) == over}
    if over == "time" and found:
        return {"time#all": np.concatenate([*found.values()], axis=1)}
    return found

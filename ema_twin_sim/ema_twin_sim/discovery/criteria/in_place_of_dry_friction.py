"""In place of dry friction: an added friction beside which the machine's own dry friction ends at nothing.

Every machine has dry friction. Over one short motion it can be made up of other laws: of friction in proportion to the
load, under a load that hardly changes, or of one that falls with the speed.
"""

from __future__ import annotations

from ...criteria import MOSTLY, SIGNIFICANT
from ...effects import Trait, catalogue, effects_with
from ...identification.equation import EquationErrorProblem
from ...identification.estimates import standard_errors
from ...identification.fit import Fit, fit
from ...identification.hypothesis import DRY_SCALE
from ...model.roles import DRY_FRICTION


def in_place_of_dry_friction(problem: EquationErrorProblem, f: Fit, name: str) -> bool:
    """Whether an added friction took the place of the open dry friction of the model, which is there without it."""
    h = f.hypothesis
    effect = catalogue()[h.instance(name).effect]
    rubs = effect.depends_on == "speed" or effect.id in effects_with(Trait.FRICTION_UNDER_LOAD)
    if not rubs or effect.id == DRY_FRICTION or not _is_gone(f):
        return False
    without = fit(problem, h.without(name), known=f)
    if f.misfit < (1.0 - MOSTLY) * without.misfit:
        return False  # dry friction does not explain what it does
    return without.hypothesis.by_path[DRY_SCALE] > SIGNIFICANT * standard_errors(problem, without)[DRY_SCALE]


def _is_gone(f: Fit) -> bool:
    """Whether the dry friction of the model is open and ended at zero."""
    numbers = zip(f.hypothesis.free, f.hypothesis.values, strict=True)
    return any(free.path == DRY_SCALE and free.prior is None and value == free.lower == 0.0 for free, value in numbers)

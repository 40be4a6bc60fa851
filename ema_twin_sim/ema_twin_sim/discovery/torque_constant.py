"""A torque constant that a load sensor tells: off by no more than its tolerance, or assumed, it is no missing effect.

The load sensor of a dynamometer tells how much torque an ampere gives, as surely as the current tells inertia and
friction. These are free within their tolerances from the start. The torque constant enters a search as an effect, so
that it competes with what acts through the current as well, and becomes a constant once that search has ended. One
that is only assumed is free from the start, as all that nobody knows of a machine.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from ema_bench_replay.recording import Recording

from ..criteria import CONTRADICTED, DEPENDS, LIKELY
from ..identification.estimates import standard_errors
from ..identification.fit import fit
from ..identification.hypothesis import EXACT, Hypothesis
from ..measured.load_sensor import load_varies, torque_per_current
from ..model import Model
from ..model.check_comment import is_assumed
from ..model.matching import by_torque
from ..model.model_file import TORQUE_CONSTANT
from ..model.roles import TORQUE_FACTOR
from .criteria.worth import penalised_gain
from .search.trace import Search

WITHIN = "it is within the tolerance of the model's torque constant, which is refitted instead"


def with_assumed_constant_free(null: Hypothesis, recordings: Sequence[Recording]) -> Hypothesis:
    """The null hypothesis with an assumed torque constant entirely free, if a measured load tells it.

    Only if other constants are open too: nobody knows those of a machine and assumes its torque constant.
    """
    constant = null.base.constants[TORQUE_CONSTANT]
    if not null.base.is_open or not is_assumed(constant.source) or TORQUE_FACTOR in null.held:
        return null
    told = None if by_torque(recordings) else torque_per_current(recordings)
    if told is None:
        return null
    (name,) = (free := null.with_effect(TORQUE_FACTOR, {}, {"scale": 1.0})).added
    return free.with_factor_as_constant(name, math.inf).put({f"scale.{TORQUE_FACTOR}": told / constant.value})


def with_factor_as_constant(found: Search, recordings: Sequence[Recording]) -> Search:
    """The search with an added factor on the torque constant as a constant, if it may lie within the tolerance.

    Only if a load that varies was measured: otherwise what tells the factor is that the other constants are off by it.
    """
    h = found.fit.hypothesis
    name = next((n for n, instance in h.added.items() if instance.effect == TORQUE_FACTOR), None)
    if name is None or not any(load_varies(recording) for recording in recordings):
        return found
    path = f"effects.{name}.scale"
    tolerance = h.base.constants[TORQUE_CONSTANT].tolerance
    off = abs(h.by_path[path] - 1.0) - LIKELY * standard_errors(found.problem, found.fit).get(path, 0.0)
    if off > tolerance:
        return found
    refitted = fit(found.problem, h.with_factor_as_constant(name, tolerance))
    # beside free constants it may be too uncertain to lie beyond its tolerance, and be needed beyond it all the same
    needed = penalised_gain(refitted, found.fit) > DEPENDS
    beyond = abs(refitted.hypothesis.by_path[f"scale.{TORQUE_FACTOR}"] - 1.0) > CONTRADICTED * max(tolerance, EXACT)
    return found if needed or beyond else found.ended(refitted, WITHIN)


def with_factor_in_the_constant(model: Model, searched: Model, given: Model) -> Model:
    """The model with a factor that became a constant in the torque constant itself.

    Such a factor is an effect of the model that was ``searched`` from at the end, and none of the ``given`` one.
    """
    for name in searched.effects.keys() - given.effects.keys():
        instance = model.effects[name]
        if instance.effect == TORQUE_FACTOR:
            constant = model.constants[TORQUE_CONSTANT]
            scaled = {TORQUE_CONSTANT: constant.at(constant.value * instance.parameters["scale"])}
            effects = {n: i for n, i in model.effects.items() if n != name}
            return replace(model, constants={**model.constants, **scaled}, effects=effects)
    return model

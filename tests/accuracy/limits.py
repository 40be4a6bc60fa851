"""Detection limits on unkind benches, against the smallest size that their rows could tell at all.

The limit of an effect on a bench is four times the standard error that Cramér and Rao leave its size, in the problem
that discovery solves: the equation-error rows of the recordings, the machine's constants free within the 5 % that they
are known to, an angle of the effect free, a speed at which it bends held at the truth. The noise is what the true model
leaves of recordings with nothing hidden, with the spectrum that this has (Blackman and Tukey's estimate by recording),
so that friction that wanders, a resonance and an encoder's interpolation are all in it.

Then the effect is hidden at multiples of its bench's own limit, on as many benches as were asked for. The limit says
when its torque shows, not when it can be told from a rival's: over a small angle gravity is a constant load. An answer
that names both, as a group that these recordings cannot tell apart, counts as named, and is counted besides.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ema_twin_sim.criteria import SIGNIFICANT
from ema_twin_sim.discovery.search.adding import settle
from ema_twin_sim.effects import catalogue
from ema_twin_sim.identification.cramer_rao import fisher_information
from ema_twin_sim.identification.equation import EquationErrorProblem
from ema_twin_sim.identification.fit import Fit, fit, prior_rows
from ema_twin_sim.identification.null_hypothesis import null_hypothesis
from ema_twin_sim.identification.uncertainty import scaled_inverse
from ema_twin_sim.measured.observe import observe_all
from ema_twin_sim.measured.scales import to_own_units

from .cases import Case
from .folders import readable_train
from .other_bench import Cause
from .other_machines import other_machine_case
from .sizes import SIZE_OF, middling_cause
from .work import Solvers

LIMITED = ("sun_runout", "cogging", "gravity_load", "stribeck_friction", "encoder_delay", "torque_ripple")
"""The effects whose limits are measured: they show over angles, the speed, the load and the encoders."""
MULTIPLES = (1.5, 3.0, 5.0, 10.0, 20.0, 50.0)
"""Of the limit, the sizes that are hidden."""
BENCHES = 10
ENOUGH = 0.8
"""Named in this share of the benches, a size counts as detected."""
SMALL = 0.01
"""Times the usual size, at which slopes are taken."""


@dataclass(frozen=True)
class Limit:
    """One bench's limit of one effect: of its size (SI of the bench), and the cause that the size is put into."""

    case: Case
    cause: Cause
    size: float

    def hidden_at(self, multiple: float) -> Case:
        """The bench with the effect hidden at a multiple of its limit."""
        name, usual = SIZE_OF[self.cause.id]
        cause = replace(self.cause, values={**self.cause.values, name: usual.zero + multiple * self.size})
        return replace(self.case, name=f"{self.case.name} x{multiple:g}", causes=(cause,))


def limits(
    seed: int, effects: Sequence[str], benches: int, solve: Solvers, say: Callable[[str], None]
) -> dict[str, dict[str, Any]]:
    """By effect, its limit (median of the benches) and the smallest multiple of it that is named in ENOUGH of them."""
    found = {}
    for id in effects:
        cases = [limited_bench(id, seed, number) for number in range(benches)]
        known = sorted(solve.each(limit_of, cases), key=lambda limit: limit.case.name)
        tried: dict[float, tuple[int, int]] = {}
        smallest = None
        for multiple in MULTIPLES:
            count = undecided = 0
            for verdict in solve([limit.hidden_at(multiple) for limit in known]):
                say(f"     {verdict.line()}")  # as it comes: each takes seconds
                undecided += verdict.undecided
                count += verdict.found or verdict.undecided
            tried[multiple] = count, undecided
            if count >= ENOUGH * benches:
                smallest = multiple
                break
        found[id] = {
            "parameter": SIZE_OF[id][0],
            "unit": catalogue()[id].parameters[0].unit,
            "limit": float(np.median([limit.size for limit in known])),
            "multiple": smallest,
            "named": tried,
        }
        say(_line(id, found[id], benches))
    return found


def limit_table(found: dict[str, dict[str, Any]], benches: int) -> str:
    """The limits of all effects, one a line."""
    return "\n".join(_line(id, of, benches) for id, of in found.items())


def limit_of(case: Case, _: Sequence[str] = ()) -> Limit:
    """The limit of the one effect that a case would hide, told by its recordings with nothing hidden."""
    (cause,) = case.causes
    bare = replace(case, causes=())
    recordings, model = to_own_units(readable_train(bare), bare.start_model)
    problem = EquationErrorProblem(observe_all(list(recordings), model))
    null = settle(fit(problem, null_hypothesis(model)))
    assert model.units is not None
    factors = {
        p.name: 1.0 if p.periodic else case.told_in.factor(p.unit) * model.units.factor(p.unit)
        for p in catalogue()[cause.id].parameters
    }
    name, usual = SIZE_OF[cause.id]
    values = {**cause.values, name: usual.zero + SMALL * (cause.values[name] - usual.zero)}
    own = {parameter: value / factors[parameter] for parameter, value in values.items()}
    options = {**catalogue()[cause.id].default_options(), **cause.options}
    with_effect = fit(null.problem, null.hypothesis.with_effect(cause.id, options, own), 0)
    return Limit(bare, cause, SIGNIFICANT * factors[name] * _standard_error(null.problem, null, with_effect, name))


def _standard_error(problem: EquationErrorProblem, true: Fit, f: Fit, size: str) -> float:
    """What the rows leave open of an effect's ``size``, in own units; ``true`` leaves the noise."""
    angles = {p.name for p in catalogue()[f.hypothesis.effects[0]].parameters if p.periodic}
    asked = [
        k
        for k, free in enumerate(f.hypothesis.free)
        if not free.path.startswith("effects.") or free.path.rpartition(".")[2] in {size, *angles}
    ]
    _, priors = prior_rows(f.hypothesis)
    information = (priors.T @ priors)[np.ix_(asked, asked)]
    information += fisher_information(problem, true.residual, f.jacobian[:, asked])
    place = [f.hypothesis.free[k].path.rpartition(".")[2] for k in asked].index(size)
    return math.sqrt(float(scaled_inverse(information, 1e-12)[place, place]))


def limited_bench(id: str, seed: int, number: int) -> Case:
    """A bench of its own, with the effect at its usual size."""
    random = np.random.default_rng((seed, 6001, LIMITED.index(id), number))
    bench = other_machine_case(f"{id}_{number}", id, (), (seed, 6000, number))
    return replace(bench, causes=(middling_cause(id, random, 1.0),))


def _line(id: str, of: dict[str, Any], benches: int) -> str:
    tried = "  ".join(
        f"{multiple:g}: {count}/{benches}" + (f", {undecided} in a group" if undecided else "")
        for multiple, (count, undecided) in of["named"].items()
    )
    smallest = f"{of['multiple']:g} x" if of["multiple"] is not None else "not named"
    return f"{id:20s} {of['parameter']} {of['limit']:.3g} {of['unit']:6s} {smallest:10s} ({tried})"

"""Where a search for play and spring begins: both ring and bounce, so that a fit from afar ends in the wrong valley.

Starts are tried on the few seconds of each recording that hold the most reversals, on a grid, with little weight on
what is far off; the best few are fitted there, and only the best of these on everything.
"""

from __future__ import annotations

import itertools
import math

import numpy as np

from ..criteria import BESIDE_IMPACTS
from ..model.roles import DRY_FRICTION, PLAY, SPRING
from .equation import EquationErrorProblem
from .excerpt import excerpt
from .fit import Fit, fits
from .hypothesis import DRY_SCALE, Hypothesis
from .local_minima import best_of, ranked, starting
from .sensors import hysteresis, with_sensors

STIFFNESS = tuple(3.0 * 1.3**k for k in range(22))
DAMPING = (0.004, 0.015, 0.05, 0.15)
WIDTHS = (0.6, 0.8, 0.88, 0.92, 0.96, 1.0)
ABOUT = (0.8, 0.9, 0.95, 1.0, 1.05, 1.1, 1.3)  # times the hysteresis of both encoders, where no torque was measured
HOLDING = (0.03, 0.1, 0.3, 1.0)  # times the friction that an output begins with
SIDES = (0.75, 1.0, 1.25)  # times the friction that the model has on the output's side
CONTACTS = ((1.0, 1.0), (2.0, 3.0), (0.6, 0.3), (2.0, 0.6))
OUTPUT_SHARE = 0.4  # of the friction, to begin with, that is at the output
SOFTER = 30  # steps of STIFFNESS further down where own units are no more than a typical speed's
HARDLY = 0.01  # times the friction that an output begins with: it swings on its spring
HOPELESS = 4.0  # times the least misfit of a start, from which on a family is left out
RIVAL = 2.0  # times the least misfit up to which a family is fitted to everything
SPRINGY = 2.0 * math.pi * 55.0  # own rad/s: what rings faster against its play rings on its teeth


def structural_fits(problem: EquationErrorProblem, current: Fit, without: frozenset[str]) -> list[Fit]:
    """The current hypothesis with play, with a spring, and with both, each from its best start, ``without`` some.

    What is fitted stands under a weighting whose outliers begin beside impacts.
    """
    h = with_sensors(problem, current, frozenset() if problem.size else without)
    if any(free.path == "scale.inertia" and free.prior is not None for free in h.free):
        # a rigid train takes an output that lags behind for a lighter one
        h = h.put({"scale.inertia": 1.0})
    h = _on_both_sides(h)
    held = h.held | without
    spread = encoder_spread(problem, h)
    part = excerpt(problem)
    springs = _springs(h)
    back_and_forth = 0.0 if h.by_torque else hysteresis(problem, current)
    families = []
    if SPRING not in held:
        wound = [h.with_effect(SPRING, {}, s) for s in springs]
        if not h.by_torque:  # nor does any tell how much friction winds it up
            held_back = [_wound_by(spring, back_and_forth) for spring in wound]
            wound += [starting(spring, {"scale.output_coulomb": HARDLY}) for spring in wound]
            wound += [spring for spring in held_back if spring is not None]
        families.append(ranked(part, wound))
    if PLAY not in held and spread > 0.0:
        families.append(ranked(part, _gaps(h, spread) if h.by_torque else _held_in_gaps(h, back_and_forth)))
    hopeless = HOPELESS * min((family[0][0] for family in families), default=0.0)
    best = [best_of(part, family) for family in families if family[0][0] <= hopeless]
    play = next((f for f in best if SPRING not in held and PLAY in f.hypothesis.effects), None)
    if play is not None:
        # the flight through the gap told its width and the output's friction: the spring is looked for from there
        width = f"effects.{list(play.hypothesis.added)[-1]}.width"
        gaps = [starting(play.hypothesis, {width: share}) for share in (0.96, 1.0, 1.04)]
        both = [gap.with_effect(SPRING, {}, s) for gap in gaps for s in springs[4:]]
        f = best_of(part, ranked(part, both))
        if not _is_contact(f):
            best.append(f)
    least = min((f.misfit for f in best), default=0.0)
    close = [f for f in best if f.misfit <= RIVAL * least or len(best) < 2]
    whole = problem.under(problem.weighting.from_outliers(BESIDE_IMPACTS))
    return fits(whole, [f.hypothesis for f in close], 6)


def _springs(h: Hypothesis) -> list[dict[str, float]]:
    """Springs and their dampings, from soft to stiff; softer ones too where no torque tells how fast a machine is."""
    if h.by_torque:
        return [{"stiffness": k, "damping": d} for k, d in itertools.product(STIFFNESS, DAMPING)]
    soft = [STIFFNESS[0] * 1.3**-k for k in range(1, SOFTER)]
    return [
        {"stiffness": k, "damping": d * math.sqrt(k / STIFFNESS[0]) if k < STIFFNESS[0] else d}
        for k, d in itertools.product((*soft, *STIFFNESS), DAMPING)
    ]


def _on_both_sides(h: Hypothesis) -> Hypothesis:
    """A hypothesis that found Coulomb friction, with a part of it at the output: a rigid train does not tell the sides
    apart, and without friction an output would fly through a gap for good.
    """
    dry = {name: h.instance(name) for name, i in h.added.items() if i.effect == DRY_FRICTION}
    if len(dry) != 1 or DRY_FRICTION in {i.effect for i in h.base.active.values()}:
        return h
    ((name, found),) = dry.items()
    h = starting(h, {f"effects.{name}.torque": 1.0 - OUTPUT_SHARE})
    shared = {**found.parameters, "torque": found.parameters["torque"] * OUTPUT_SHARE}
    return h.with_effect(DRY_FRICTION, {**found.options, "side": "output"}, shared)


def _gaps(h: Hypothesis, spread: float) -> list[Hypothesis]:
    """A hypothesis with play: gaps of a few widths, teeth of a few kinds, friction on either side."""
    gaps = [h.with_effect(PLAY, {}, {"width": spread * share}) for share in WIDTHS]
    return [
        starting(gap, {**side, "contact.stiffness": stiffness, "contact.damping": damping})
        for gap, side, (stiffness, damping) in itertools.product(gaps, _sides(gaps[0]), CONTACTS)
    ]


def _held_in_gaps(h: Hypothesis, hysteresis: float) -> list[Hypothesis]:
    """A hypothesis with play of about the encoders' ``hysteresis`` [rad], in which some friction holds the output."""
    gaps = [h.with_effect(PLAY, {}, {"width": hysteresis * share}) for share in ABOUT]
    return [starting(gap, {"scale.output_coulomb": held}) for gap, held in itertools.product(gaps, HOLDING)]


def _wound_by(spring: Hypothesis, hysteresis: float) -> Hypothesis | None:
    """A hypothesis with a spring that its output's friction winds up by the encoders' ``hysteresis`` [rad].

    None where the model has no friction at its output.
    """
    model = spring.model()
    friction = sum(
        instance.parameters["torque"]
        for instance in model.active.values()
        if instance.effect == DRY_FRICTION and instance.options["side"] == "output"
    )
    if not friction > 0.0:
        return None
    stiffness = spring.instance(list(spring.added)[-1]).parameters["stiffness"]
    torque = 0.5 * hysteresis * model.value("machine.gear_ratio") * stiffness  # one way and the other
    return starting(spring, {"scale.output_coulomb": torque / friction})


def _is_contact(f: Fit) -> bool:
    """Whether a spring beside play is but the teeth's own contact."""
    plant = f.predicted.plant[0]
    return bool(plant["contact_stiffness"] > plant["output_inertia"] * SPRINGY**2)


def _sides(h: Hypothesis) -> list[dict[str, float]]:
    """Factors that put more or less of the friction on the output's side, their sum as it was."""
    dry = h.model().active.values()
    torque = {
        side: sum(i.parameters["torque"] for i in dry if i.effect == DRY_FRICTION and i.options["side"] == side)
        for side in ("motor", "output")
    }
    return [
        {
            "scale.output_coulomb": share,
            DRY_SCALE: max(0.0, 1.0 - (share - 1.0) * torque["output"] / max(torque["motor"], 1e-12)),
        }
        for share in SIDES
    ]


def encoder_spread(problem: EquationErrorProblem, h: Hypothesis) -> float:
    """How far the encoders part over a reversal [rad, slow shaft], less what their errors do: the widest recording.

    A hypothesis of stiff gears has these errors: an encoder that is late parts from the other by its delay at each
    speed, which may be far more than the play beside it.
    """
    errors = 0.0 if h.parted else problem.predict(h).rows[problem.size :] * problem.encoder_noise
    apart = problem.encoder - errors
    return max(
        (
            float(np.ptp(np.quantile(apart[p.start - problem.size : p.stop - problem.size], (0.02, 0.98))))
            for p in problem.encoder_parts
            if p.stop > p.start
        ),
        default=0.0,
    )

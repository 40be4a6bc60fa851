"""Start values for backlash and compliance.

Both ring and bounce, so a fit from a distant start ends in the wrong local minimum.

Starts are tried on a grid, on the few seconds of each recording with the most reversals, with little weight on
outliers. The best few are fitted there, and only the best of these on everything.
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
from .hypothesis import DRY_SCALE, Hypothesis, dry_friction
from .local_minima import best_of, ranked, starting
from .sensors import hysteresis, with_sensors

STIFFNESS = tuple(3.0 * 1.3**k for k in range(22))
DAMPING = (0.004, 0.015, 0.05, 0.15)
WIDTHS = (0.6, 0.8, 0.88, 0.92, 0.96, 1.0)
ABOUT = (0.8, 0.9, 0.95, 1.0, 1.05, 1.1, 1.3)  # factors on the hysteresis of both encoders, without torque data
HOLDING = (0.03, 0.1, 0.3, 1.0)  # factors on the friction that an output begins with
SIDES = (0.75, 1.0, 1.25)  # factors on the model's friction on the output side
CONTACTS = ((1.0, 1.0), (2.0, 3.0), (0.6, 0.3), (2.0, 0.6))
OUTPUT_SHARE = 0.4  # initial share of the friction at the output
SOFTER = 30  # more steps of STIFFNESS downwards if own units follow only from a typical speed
HARDLY = 0.01  # factor on the output's initial friction: the output swings on its spring
HOPELESS = 4.0  # a family is dropped from this multiple of the least misfit of a start
RIVAL = 2.0  # a family is fitted to everything up to this multiple of the least misfit
SPRINGY = 2.0 * math.pi * 55.0  # own rad/s: with backlash, what rings faster is the contact of the teeth


def structural_fits(problem: EquationErrorProblem, current: Fit, without: frozenset[str]) -> list[Fit]:
    """The current hypothesis with backlash, with compliance, and with both, each from its best start.

    Effects in ``without`` are not added. The fits are under a weighting that suits impacts.
    """
    h = with_sensors(problem, current, without)
    if any(free.path == "scale.inertia" and free.prior is not None for free in h.free):
        # a rigid drivetrain takes an output that lags for a lighter one
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
        if not h.by_torque:  # the friction that winds it up is unknown as well
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
        # the flight through the gap gave its width and the output's friction: search for the compliance from there
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
    """Stiffness and damping values, from soft to stiff.

    Without torque data also softer ones, since it is then unknown how fast the machine is.
    """
    if h.by_torque:
        return [{"stiffness": k, "damping": d} for k, d in itertools.product(STIFFNESS, DAMPING)]
    soft = [STIFFNESS[0] * 1.3**-k for k in range(1, SOFTER)]
    return [
        {"stiffness": k, "damping": d * math.sqrt(k / STIFFNESS[0]) if k < STIFFNESS[0] else d}
        for k, d in itertools.product((*soft, *STIFFNESS), DAMPING)
    ]


def _on_both_sides(h: Hypothesis) -> Hypothesis:
    """Move part of an added Coulomb friction to the output side.

    A rigid drivetrain does not distinguish the sides, and an output without friction would never come to rest in a gap.
    """
    dry = {name: h.instance(name) for name, i in h.added.items() if i.effect == DRY_FRICTION}
    if len(dry) != 1 or DRY_FRICTION in {i.effect for i in h.base.active.values()}:
        return h
    ((name, found),) = dry.items()
    h = starting(h, {f"effects.{name}.torque": 1.0 - OUTPUT_SHARE})
    shared = {**found.parameters, "torque": found.parameters["torque"] * OUTPUT_SHARE}
    return h.with_effect(DRY_FRICTION, {**found.options, "side": "output"}, shared)


def _gaps(h: Hypothesis, spread: float) -> list[Hypothesis]:
    """Hypotheses with backlash: several widths, tooth contacts, and divisions of the friction."""
    gaps = [h.with_effect(PLAY, {}, {"width": spread * share}) for share in WIDTHS]
    return [
        starting(gap, {**side, "contact.stiffness": stiffness, "contact.damping": damping})
        for gap, side, (stiffness, damping) in itertools.product(gaps, _sides(gaps[0]), CONTACTS)
    ]


def _held_in_gaps(h: Hypothesis, hysteresis: float) -> list[Hypothesis]:
    """Hypotheses with backlash of about the encoders' ``hysteresis`` [rad], in which friction holds the output."""
    gaps = [h.with_effect(PLAY, {}, {"width": hysteresis * share}) for share in ABOUT]
    return [starting(gap, {"scale.output_coulomb": held}) for gap, held in itertools.product(gaps, HOLDING)]


def _wound_by(spring: Hypothesis, hysteresis: float) -> Hypothesis | None:
    """Hypothesis with a spring that the output's friction winds up by the encoders' ``hysteresis`` [rad].

    None if the model has no friction at its output.
    """
    model = spring.model()
    friction = dry_friction(model.active.values())["output"]
    if not friction > 0.0:
        return None
    stiffness = spring.instance(list(spring.added)[-1]).parameters["stiffness"]
    torque = 0.5 * hysteresis * model.value("machine.gear_ratio") * stiffness  # torque in both directions
    return starting(spring, {"scale.output_coulomb": torque / friction})


def _is_contact(f: Fit) -> bool:
    """Whether a compliance found with backlash is only the teeth's own contact."""
    plant = f.predicted.plant[0]
    return bool(plant["contact_stiffness"] > plant["output_inertia"] * SPRINGY**2)


def _sides(h: Hypothesis) -> list[dict[str, float]]:
    """Factors that put more or less of the friction on the output side, with the sum unchanged."""
    torque = dry_friction(h.model().active.values())
    return [
        {
            "scale.output_coulomb": share,
            DRY_SCALE: max(0.0, 1.0 - (share - 1.0) * torque["output"] / max(torque["motor"], 1e-12)),
        }
        for share in SIDES
    ]


def encoder_spread(problem: EquationErrorProblem, h: Hypothesis) -> float:
    """Encoder difference over a reversal [rad, slow shaft], less the encoder errors of ``h``: widest of all recordings.

    A delayed encoder differs from the other in proportion to the speed, which may be several times the backlash. The
    errors are subtracted only if ``h`` has a rigid gearbox.
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

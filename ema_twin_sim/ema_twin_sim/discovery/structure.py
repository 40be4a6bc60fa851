"""Where a search for play and spring begins: both ring and bounce, so that a fit from afar ends in the wrong valley.

Starts are tried on the few seconds of each recording that hold the most reversals, on a grid, with little weight on
what is far off; the best few are fitted there, and only the best of these on everything.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np

from ..plant.measured_motion import SPEED
from .equation import POOL, Equation, Fit, fit
from .hypothesis import Hypothesis
from .observation import STANDSTILL

WIDE = 30.0  # noise standard deviations from which on a row counts less while starts are compared
NARROW = 10.0  # the same once the starts are left behind
STIFFNESS = tuple(3.0 * 1.3**k for k in range(22))
DAMPING = (0.004, 0.015, 0.05, 0.15)
WIDTHS = (0.6, 0.8, 0.88, 0.92, 0.96, 1.0)
EXCERPT = 4.0  # s
EXCERPTS = 4
CONTACTS = ((1.0, 1.0), (2.0, 3.0), (0.6, 0.3), (4.0, 1.0))
FINALISTS = 3
RIVAL = 2.0  # times the least misfit up to which a family is fitted to everything
SPRINGY = 2.0 * math.pi * 55.0  # rad/s: an output that rings faster against its play rings on its teeth
OVERDAMPED = 0.7


def structural_fits(eq: Equation, current: Fit) -> list[Fit]:
    """The current hypothesis with play, with a spring, and with both, each from its best start."""
    h = current.hypothesis
    for name in h.decoys:  # columns of whole recordings; an excerpt has none
        h = h.without_decoy(name)
    held = {i.effect for i in (*h.added.values(), *h.base.effects.values())}
    spread = _spread(eq)
    part = excerpt(eq)
    springs = [{"stiffness": k, "damping": d} for k, d in itertools.product(STIFFNESS, DAMPING)]
    widths = [{"width": spread * share} for share in WIDTHS] if spread > 0.0 else []
    families: list[list[Hypothesis]] = []
    if "backlash" not in held:
        families.append([_with_contact(h.with_effect("backlash", {}, w), c) for w in widths for c in CONTACTS])
    if "shaft_compliance" not in held:
        families.append([h.with_effect("shaft_compliance", {}, s) for s in springs])
        if "backlash" not in held:
            families.append(
                [
                    h.with_effect("shaft_compliance", {}, s).with_effect("backlash", {}, w)
                    for s, w in itertools.product(springs[4:], widths[1:])
                ]
            )
    best = [_best_of(part, family) for family in families if family]
    best = [f for f in best if not _is_contact(f)]
    least = min((f.misfit for f in best), default=0.0)
    close = [f for f in best if f.misfit <= RIVAL * least or len(best) < 2]
    eq.reach = np.full(eq.rows, NARROW)
    return [fit(eq, f.hypothesis, 6) for f in close]


def _is_contact(f: Fit) -> bool:
    """Whether a spring beside play is but the teeth's own contact: stiff, or damped to death."""
    plant = f.predicted.plant[0]
    if not {"backlash", "shaft_compliance"} <= set(f.hypothesis.effects):
        return False
    stiffness, inertia = plant["contact_stiffness"], plant["output_inertia"]
    damping_ratio = plant["contact_damping"] / (2.0 * math.sqrt(stiffness * inertia))
    return bool(stiffness > inertia * SPRINGY**2 or damping_ratio > OVERDAMPED)


def _with_contact(h: Hypothesis, factors: tuple[float, float]) -> Hypothesis:
    """A hypothesis with play whose teeth are stiffer and more damped by these factors than where a search begins."""
    values = h.values.copy()
    for k, free in enumerate(h.free):
        if free.path == "contact.stiffness":
            values[k] *= factors[0]
        elif free.path == "contact.damping":
            values[k] *= factors[1]
    return h.at(values)


def excerpt(eq: Equation) -> Equation:
    """The seconds of each recording that hold the most reversals, of a few recordings."""
    found = []
    for o in eq.observations:
        if not len(o.encoder_rows):
            continue
        length = min(len(o.motion), round(EXCERPT / o.period))
        speed = o.motion[:, SPEED]
        turns = np.concatenate([[0.0], np.cumsum(np.diff(np.sign(speed)) != 0)])
        moving = np.concatenate([[0.0], np.cumsum(np.abs(speed) > STANDSTILL)])
        count = turns[length - 1 :] - turns[: len(turns) - length + 1]
        share = (moving[length:] - moving[: len(moving) - length]) / length
        count = np.minimum(count, 8)[: len(share)] * share  # chatter at standstill is no reversal
        if len(count) == 0:
            continue
        first = int(np.argmax(count))
        found.append((float(count[first]), o.window(first, first + length)))
    found.sort(key=lambda entry: -entry[0])
    return Equation([o for _, o in found[:EXCERPTS]])


def _best_of(part: Equation, family: Sequence[Hypothesis]) -> Fit:
    """The best fit of a family to an excerpt: grid, then fits of the best few."""
    part.reach = np.full(part.rows, WIDE)

    def cost(h: Hypothesis) -> float:
        return part.misfit(part.residual(part.predict(h)))

    costs = list(POOL.map(cost, family))
    finalists = []
    for k in np.argsort(costs)[:FINALISTS]:
        part.reach = np.full(part.rows, WIDE)
        f = fit(part, family[int(k)], 8)
        part.reach = np.full(part.rows, NARROW)
        finalists.append(fit(part, f.hypothesis, 8))
    return min(finalists, key=lambda f: f.misfit + f.prior_cost)


def _spread(eq: Equation) -> float:
    """How far the encoders part over a reversal [rad, slow shaft]: the widest of all recordings."""
    return max(
        (
            float(np.ptp(np.quantile(eq.encoder[p.start - eq.size : p.stop - eq.size], (0.02, 0.98))))
            for p in eq.encoder_parts
            if p.stop > p.start
        ),
        default=0.0,
    )

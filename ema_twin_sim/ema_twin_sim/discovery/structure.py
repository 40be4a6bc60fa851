"""Where a search for play and spring begins: both ring and bounce, so that a fit from afar ends in the wrong valley.

Starts are tried on the few seconds of each recording that hold the most reversals, on a grid, with little weight on
what is far off; the best few are fitted there, and only the best of these on everything.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ..plant.measured_motion import SPEED
from .equation import POOL, Equation
from .fit import Fit, fit
from .hypothesis import Hypothesis
from .observation import STANDSTILL, Observation
from .sensors import with_sensors

WIDE = 30.0  # noise standard deviations from which on a row counts less while starts are compared
NARROW = 10.0  # the same once the starts are left behind
STIFFNESS = tuple(3.0 * 1.3**k for k in range(22))
DAMPING = (0.004, 0.015, 0.05, 0.15)
WIDTHS = (0.6, 0.8, 0.88, 0.92, 0.96, 1.0)
EXCERPT = 4.0  # s
EXCERPTS = 4
MOST_TURNS = 8  # reversals of an excerpt from which on more tell no more
SIDES = (0.75, 1.0, 1.25)  # times the friction that the model has on the output's side
CONTACTS = ((1.0, 1.0), (2.0, 3.0), (0.6, 0.3), (2.0, 0.6))
FINALISTS = 3
STIFFER = (0.8, 0.9, 1.0, 1.1, 1.25)  # times a stiffness, and times a damping, that a hop leads to
DAMPED = (0.25, 0.5, 1.0, 2.0, 4.0)
LANDINGS = 1  # of the places around, those that a fit begins from
ROUNDS = 3  # of such hops, at most
FALL = 0.97  # of the misfit: a hop that gains less ends them
RIVAL = 2.0  # times the least misfit up to which a family is fitted to everything
SPRINGY = 2.0 * math.pi * 55.0  # rad/s: an output that rings faster against its play rings on its teeth


def structural_fits(eq: Equation, current: Fit) -> list[Fit]:
    """The current hypothesis with play, with a spring, and with both, each from its best start."""
    h = with_sensors(eq, current)
    for name in h.decoys:  # columns of whole recordings; an excerpt has none
        h = h.without_decoy(name)
    # a rigid train takes an output that lags behind for a lighter one
    h = h.at(np.array([1.0 if free.path == "scale.inertia" else v for free, v in zip(h.free, h.values, strict=True)]))
    held = {i.effect for i in (*h.added.values(), *h.base.effects.values())}
    spread = _spread(eq)
    part = excerpt(eq)
    springs = [{"stiffness": k, "damping": d} for k, d in itertools.product(STIFFNESS, DAMPING)]
    best: list[Fit] = []
    if "shaft_compliance" not in held:
        best.append(_best_of(part, [h.with_effect("shaft_compliance", {}, s) for s in springs]))
    if "backlash" not in held and spread > 0.0:
        gaps = [h.with_effect("backlash", {}, {"width": spread * share}) for share in WIDTHS]
        starts = [
            _starting(gap, {**side, "contact.stiffness": stiffness, "contact.damping": damping})
            for gap, side, (stiffness, damping) in itertools.product(gaps, _sides(gaps[0]), CONTACTS)
        ]
        play = _best_of(part, starts)
        best.append(play)
        if "shaft_compliance" not in held:
            # the flight through the gap told its width and the output's friction: the spring is looked for from there
            gaps = [_starting(play.hypothesis, {f"effects.{_named(play)}.width": share}) for share in (0.96, 1.0, 1.04)]
            both = _best_of(part, [gap.with_effect("shaft_compliance", {}, s) for gap in gaps for s in springs[4:]])
            if not _is_contact(both):
                best.append(both)
    least = min((f.misfit for f in best), default=0.0)
    close = [f for f in best if f.misfit <= RIVAL * least or len(best) < 2]
    eq.reach = np.full(eq.rows, NARROW)
    return [fit(eq, f.hypothesis, 6) for f in close]


def _is_contact(f: Fit) -> bool:
    """Whether a spring beside play is but the teeth's own contact."""
    plant = f.predicted.plant[0]
    return bool(plant["contact_stiffness"] > plant["output_inertia"] * SPRINGY**2)


def _sides(h: Hypothesis) -> list[dict[str, float]]:
    """Factors that put more or less of the friction on the output's side, their sum as it was."""
    dry = h.model().effects.values()
    torque = {
        side: sum(i.parameters["torque"] for i in dry if i.effect == "coulomb_friction" and i.options["side"] == side)
        for side in ("motor", "output")
    }
    return [
        {
            "scale.output_coulomb": share,
            "scale.coulomb_friction": max(0.0, 1.0 - (share - 1.0) * torque["output"] / max(torque["motor"], 1e-12)),
        }
        for share in SIDES
    ]


def _named(f: Fit) -> str:
    """The name that the last effect of a fit bears."""
    return list(f.hypothesis.added)[-1]


def _starting(h: Hypothesis, factors: Mapping[str, float]) -> Hypothesis:
    """A hypothesis some of whose numbers, by path, are multiplied."""
    return h.at(np.array([v * factors.get(free.path, 1.0) for free, v in zip(h.free, h.values, strict=True)]))


def excerpt(eq: Equation) -> Equation:
    """The seconds of each recording that hold the most reversals, of a few recordings."""
    found = []
    for o in eq.observations:
        if len(o.encoder_rows):
            length = min(len(o.motion) - 1, round(EXCERPT / o.period))
            first, count = _most_reversals(o, length)
            found.append((count, o.window(first, first + length)))
    found.sort(key=lambda entry: -entry[0])
    return Equation([o for _, o in found[:EXCERPTS]])


def _most_reversals(o: Observation, length: int) -> tuple[int, float]:
    """(first sample, reversals times share in motion) of the best stretch of so many samples."""
    speed = o.motion[:, SPEED]
    turns = np.concatenate([[0.0], np.cumsum(np.diff(np.sign(speed)) != 0)])
    moving = np.concatenate([[0.0], np.cumsum(np.abs(speed) > STANDSTILL)])
    count = turns[length - 1 :] - turns[: len(turns) - length + 1]
    share = (moving[length:] - moving[: len(moving) - length]) / length
    count = np.minimum(count, MOST_TURNS)[: len(share)] * share  # chatter at standstill is no reversal
    first = int(np.argmax(count))
    return first, float(count[first])


def _best_of(part: Equation, family: Sequence[Hypothesis]) -> Fit:
    """The best fit of a family to an excerpt: grid, then fits of the best few."""
    part.reach = np.full(part.rows, WIDE)

    def cost(h: Hypothesis) -> float:
        return part.misfit(part.residual(part.predict(h)))

    costs = list(POOL.map(cost, family))
    finalists = [fit(part, family[int(k)], 8).hypothesis for k in np.argsort(costs)[:FINALISTS]]
    part.reach = np.full(part.rows, NARROW)
    return hopped(part, min((fit(part, h, 8) for h in finalists), key=_cost))


def hopped(eq: Equation, best: Fit) -> Fit:
    """The best of a fit and those that start beside it: ringing and bounces make many valleys side by side.

    One start has all constants as the model file has them: a valley that was entered without the last effect, to make
    up for which they gave way, is not one that a fit finds out of.
    """
    for _ in range(ROUNDS):
        beside = [_starting(best.hypothesis, hop) for hop in _hops(best.hypothesis)]
        costs = list(POOL.map(lambda h: eq.misfit(eq.residual(eq.predict(h))), beside))
        starts = [beside[int(k)] for k in np.argsort(costs)[:LANDINGS]]
        starts.append(
            best.hypothesis.at(
                np.array(
                    [
                        f.prior[0] if f.prior else v
                        for f, v in zip(best.hypothesis.free, best.hypothesis.values, strict=True)
                    ]
                )
            )
        )
        better = min((fit(eq, h, 8) for h in starts), key=_cost)
        much = _cost(better) < FALL * _cost(best)
        best = min(best, better, key=_cost)
        if not much:
            break
    return best


def _hops(h: Hypothesis) -> Iterator[dict[str, float]]:
    """Factors, by path, that lead beside a hypothesis: stiffness and damping of one effect, or of the teeth."""
    springs = dict.fromkeys(f.path.rpartition(".")[0] for f in h.free if f.path.endswith((".stiffness", ".damping")))
    for spring in springs:
        for stiffness, damping in itertools.product(STIFFER, DAMPED):
            yield {f"{spring}.stiffness": stiffness, f"{spring}.damping": damping}


def _cost(f: Fit) -> float:
    return f.misfit + f.prior_cost


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

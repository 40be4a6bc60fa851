"""Orders that a residual shows, on a machine of which not all are known: they are found, not assumed."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ..comparison.orders import find_order
from ..effects import catalogue
from ..plant.measured_motion import MOTOR_ANGLE, SPEED
from .candidates import Candidate
from .equation import Equation
from .fit import Fit
from .observation import Observation

HIGHEST = 160
MOST = 3  # orders that are tried in a round
FEWEST_TURNS = 0.4  # of the motor
SLOW = 0.1  # quantile of the speeds: what is fast passes over a wave, what is slow resolves it
SAME = 1e-4  # rad, within which two points are of one angle
WHOLE = 0.02  # of an order, within which it is a whole number
LEAST_SHARE = 0.05  # of a residual's power that an order of the gears must explain


def order_candidates(eq: Equation, f: Fit) -> list[Candidate]:
    """Effects whose order is free, at the orders that stand out of a fit's residual.

    None where the machine has no others than the usual.

    What the motor's own turns bring about repeats with each of them: its orders are whole numbers. What its gears bring
    about repeats with turns of their own.
    """
    if not f.hypothesis.base.other_orders:
        return []
    found = [("cogging", str(order)) for order in standing_out(eq, f)]
    if f.hypothesis.base.value("machine.gear_ratio") != 1.0 and (order := of_the_gears(eq, f)) is not None:
        found.append(("mesh_ripple", f"{order:.5g}"))
    held = {(i.effect, i.options.get("order")) for i in f.hypothesis.added.values()}
    return [
        Candidate(id, {**catalogue()[id].default_options(), "order": order})
        for id, order in found
        if order not in catalogue()[id].options["order"] and (id, order) not in held
    ]


def of_the_gears(eq: Equation, f: Fit) -> float | None:
    """The strongest order, of all that are resolved; None where it is whole, as those of the motor are, or unclear."""
    parts = []
    for o, part in zip(eq.observations, eq.torque_parts, strict=True):
        angle, speed = o.motor_origin + o.motion[o.rows, MOTOR_ANGLE], o.motion[o.rows, SPEED]
        if not o.of_points:
            parts.append((f.residual[part], angle, np.sign(speed)))
    strongest = find_order(parts)
    if strongest is None or strongest.dissipative or strongest.share < LEAST_SHARE:
        return None
    return None if abs(strongest.order - round(strongest.order)) < WHOLE else strongest.order


def highest_order(o: Observation) -> float:
    """The order from which on the rows of an observation no longer resolve a wave: two rows a cycle, and no aliases."""
    if not o.of_points:
        step = float(np.quantile(np.abs(o.motion[o.rows, SPEED]), SLOW)) * o.period if len(o.rows) else 0.0
        return np.pi / step if step > 0.0 else np.inf
    angle = o.motion[o.rows, MOTOR_ANGLE]
    if len(angle) < 2 or np.ptp(angle) == 0.0:
        return 0.0
    turned = np.mod(angle, 2.0 * np.pi) if np.ptp(angle) > 2.0 * np.pi else angle
    steps = np.diff(np.unique(np.round(turned / SAME))) * SAME
    return float(np.pi / np.median(steps)) if len(steps) else 0.0


def resolved(eq: Equation, options: Iterable[Candidate]) -> list[Candidate]:
    """The candidates less those of orders that no table of points resolves."""
    if not all(o.of_points for o in eq.observations):
        return list(options)
    highest = max((highest_order(o) for o in eq.observations), default=np.inf)
    return [c for c in options if "order" not in c.options or float(c.options["order"]) < highest]


def standing_out(eq: Equation, f: Fit) -> list[int]:
    """The orders, in cycles per turn of the motor, with the most power, as far up as the samples resolve them."""
    orders = np.arange(1, HIGHEST + 1)
    power = np.zeros(len(orders))
    for o, part in zip(eq.observations, eq.torque_parts, strict=True):
        angle = o.motor_origin + o.motion[o.rows, MOTOR_ANGLE]
        if not len(angle) or np.ptp(angle) < 2.0 * np.pi * FEWEST_TURNS:
            continue
        highest = highest_order(o)
        residual = f.residual[part] - f.residual[part].mean()
        turn = np.exp(1j * angle)
        wave = np.ones(len(angle), complex)
        for k, order in enumerate(orders):
            wave *= turn
            if order < highest:
                power[k] += abs(residual @ wave) ** 2 / len(angle)
    return [int(orders[k]) for k in np.argsort(-power)[:MOST] if power[k] > 0.0]

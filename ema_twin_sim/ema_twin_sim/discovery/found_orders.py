"""Orders that a residual shows, on a machine whose orders nobody has named: they are found, not assumed."""

from __future__ import annotations

import numpy as np

from ..effects import catalogue
from ..plant.measured_motion import MOTOR_ANGLE, SPEED
from .candidates import Candidate
from .equation import Equation
from .fit import Fit

HIGHEST = 160
MOST = 3  # orders that are tried in a round
FEWEST_TURNS = 0.4  # of the motor


def order_candidates(eq: Equation, f: Fit) -> list[Candidate]:
    """Effects whose order is free, at the orders that stand out of a fit's residual; none where the model names them.

    What the motor's own turns bring about repeats with each of them: its orders are whole numbers.
    """
    if f.hypothesis.base.orders:
        return []
    free = [effect for effect in catalogue().values() if effect.free_option == "order"]
    held = {(i.effect, i.options.get("order")) for i in f.hypothesis.added.values()}
    orders = [str(order) for order in standing_out(eq, f)]
    return [
        Candidate(effect.id, {**effect.default_options(), "order": order})
        for effect in free
        for order in orders
        if order not in effect.options["order"] and (effect.id, order) not in held
    ]


def standing_out(eq: Equation, f: Fit) -> list[int]:
    """The orders, in cycles per turn of the motor, with the most power, as far up as the samples resolve them."""
    orders = np.arange(1, HIGHEST + 1)
    power = np.zeros(len(orders))
    for o, part in zip(eq.observations, eq.torque_parts, strict=True):
        angle = o.motor_origin + o.motion[o.rows, MOTOR_ANGLE]
        if not len(angle) or np.ptp(angle) < 2.0 * np.pi * FEWEST_TURNS:
            continue
        step = float(np.median(np.abs(o.motion[o.rows, SPEED]))) * o.period if not o.of_points else 0.0
        residual = f.residual[part] - f.residual[part].mean()
        turn = np.exp(1j * angle)
        wave = np.ones(len(angle), complex)
        for k, order in enumerate(orders):
            wave *= turn
            if order * step < np.pi:
                power[k] += abs(residual @ wave) ** 2 / len(angle)
    return [int(orders[k]) for k in np.argsort(-power)[:MOST] if power[k] > 0.0]

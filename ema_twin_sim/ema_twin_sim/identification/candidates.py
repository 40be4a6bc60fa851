"""Candidates: every effect of the catalogue with each choice of its options, and the starts of its search."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from ..effects import Effect, Trait, catalogue, effects_with
from ..effects.catalogue import is_own
from ..model.own_units import OwnUnits, is_linear, table_in
from ..model.roles import DRY_FRICTION, SENSOR_WAVE
from ..plant.layout import ANGLE_ERRORS, TORQUE
from .hypothesis import Hypothesis
from .search_limits import Reached
from .start_values import start_values


@dataclass(frozen=True)
class Candidate:
    """One effect with one choice of its options."""

    effect: str
    options: Mapping[str, str]

    @property
    def name(self) -> str:
        """The effect and its options as one word."""
        chosen = ",".join(f"{k}={v}" for k, v in self.options.items())
        return f"{self.effect}({chosen})" if chosen else self.effect


def candidates(h: Hypothesis, without: frozenset[str] = frozenset()) -> list[Candidate]:
    """The effects that may be added to a hypothesis."""
    found = []
    for id, effect in catalogue().items():
        if id in without or not effect.searched or not addable(h, id):
            continue
        if effect.electrical and h.base.pole_pairs is None:
            continue
        if effect.free_option and is_linear(h.base):
            continue  # no order is a usual one along a line; those that the recordings show are found separately
        if effect.depends_on == "acceleration" and Trait.LIKE_A_CONSTANT in effect.traits and h.inertia_is_open:
            continue  # the same number twice
        added = [dict(instance.options) for instance in h.added.values() if instance.effect == id]
        if effect.law and added:
            continue  # under another law it would be the same cause twice
        laws = {i.options[effect.law] for i in h.base.active.values() if effect.law and i.effect == id}
        for choice in itertools.product(*effect.options.values()):
            options = dict(zip(effect.options, choice, strict=True))
            if laws and options[effect.law] not in laws:
                continue  # the model tells which law this machine follows
            # a rigid drivetrain does not distinguish the sides
            unsided = h.parted or options.get("side", "motor") == "motor"
            elsewhere = _of_another_gearbox(h, options) or _is_gravity(h, effect, options, without)
            if options not in added and unsided and not elsewhere:
                found.append(Candidate(id, options))
    return found


def _of_another_gearbox(h: Hypothesis, options: Mapping[str, str]) -> bool:
    """Whether an order belongs to the teeth of the catalogue's own gearbox, on a machine that may have another one.

    Whole orders fit any shaft. Other orders are candidates there only if the model names them; those that the
    recordings show are found separately.
    """
    order = float(options.get("order", 1.0))
    named = any(math.isclose(order, known, rel_tol=1e-3) for known in h.base.orders.values())
    return h.base.other_orders and not order.is_integer() and not named


def _is_gravity(h: Hypothesis, effect: Effect, options: Mapping[str, str], without: frozenset[str]) -> bool:
    """Whether an effect is a torque once per turn of a motor that turns its output: gravity is the same.

    Not on a carriage, which has no turns, nor if gravity is excluded.
    """
    weights = effects_with(Trait.LOAD) & effects_with(Trait.OF_OUTPUT_TURNS)
    if not h.base.is_direct or is_linear(h.base) or is_own(effect) or weights <= without:
        return False
    once = effect.depends_on == "order" and float(options.get("order", 1.0)) == 1.0 and not effect.electrical
    return once and effect.wave_angle is not None and effect.where(options) == TORQUE


def addable(h: Hypothesis, id: str) -> bool:
    """Whether a plant can take one more instance of an effect than a hypothesis has.

    Friction in excess of the dry friction is refused where there is no dry friction: it would take its place.
    """
    if id == SENSOR_WAVE and h.count(id) >= ANGLE_ERRORS:
        return False
    if Trait.ABOVE_DRY_FRICTION in catalogue()[id].traits and DRY_FRICTION not in h.held:
        return False
    return catalogue()[id].repeatable or id not in h.held


def starts(c: Candidate, of: Reached, units: OwnUnits | None) -> Iterator[dict[str, float]]:
    """Shape parameters from which the search of an effect begins: all but a size in which it is linear.

    They are in the ``units`` of the model. None if the recordings do not show what these options do.
    """
    effect = table_in(catalogue()[c.effect], units)
    size = effect.parameters[0]
    shapes = [p for p in effect.parameters_with(c.options) if p is not size or p.neutral is None]
    for choice in itertools.product(*(start_values(effect, p, of) for p in shapes)):
        yield dict(zip((p.name for p in shapes), choice, strict=True))

"""The steps of a search that led nowhere: effects that were added and dropped again, in one sentence."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from ..discovery.steps import Step
from ..effects import catalogue
from ..listing import listed
from .sentences import effect_words

_FEW = 2  # dropped effects that keep their rows


def less_dropped(steps: Sequence[Step]) -> tuple[list[Step], str]:
    """The steps without those of effects that were dropped again, and a sentence on these.

    Up to two of them stay among the steps; then there is no sentence.
    """
    added = {step.instance for step in steps if step.action == "add"}
    last = {step.instance: step for step in steps}  # what came back, and stayed, was added last
    dropped = {name: step for name, step in last.items() if step.action != "add" and name in added}
    if len(dropped) <= _FEW:
        return list(steps), ""
    by_reason: dict[str, list[Step]] = {}
    for step in dropped.values():
        by_reason.setdefault(step.reason, []).append(step)
    told = "; ".join(f"{listed(_named(each))}: {reason}" for reason, each in by_reason.items())
    return [step for step in steps if step.instance not in dropped], f"Tried and dropped again: {told}."


def _named(steps: Sequence[Step]) -> list[str]:
    """The effects of these steps in words; how many of each, if there were several."""
    named = []
    for id, count in Counter(step.effect for step in steps).items():
        often = f" at {count} orders" if catalogue()[id].depends_on == "order" else f" ({count} times)"
        named.append(f"{effect_words(id)}{often if count > 1 else ''}")
    return named

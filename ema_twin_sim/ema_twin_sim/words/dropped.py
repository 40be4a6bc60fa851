"""The steps of a search that led nowhere: effects that were added and dropped again, in one sentence."""

from __future__ import annotations

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
    count: dict[str, int] = {}
    for step in steps:
        count[step.effect] = count.get(step.effect, 0) + 1
    repeating = {id for id, effect in catalogue().items() if effect.depends_on == "order"}
    return [
        effect_words(id)
        if number == 1
        else f"{effect_words(id)} {f'at {number} orders' if id in repeating else f'({number} times)'}"
        for id, number in count.items()
    ]

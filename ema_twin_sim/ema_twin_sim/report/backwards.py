"""Detect two models given in the wrong order: the later lacks effects of the earlier, or is farther off."""

from __future__ import annotations

from ..comparison.closeness import closer
from ..listing import listed
from ..words.sentences import effect_words
from .content import Content, signals_listed

_FARTHER = 0.95
"""A model that is fewer times closer than this counts as farther off."""


def backwards(content: Content) -> str:
    """A sentence if the later model lacks effects of the earlier, or is farther from the recordings; else empty."""
    before, after = content.names[:2]
    gone = list(dict.fromkeys(effect_words(effect.name) for effect in content.gone))
    farther, everywhere = _farther(content)
    parts = []
    if gone:
        parts.append(f"lacks {listed(gone)}, which the first, {before}, has")
    if farther:
        than = "" if gone else f" than the first, {before}"
        where = "" if everywhere else f" in {signals_listed(content.given, farther)}"
        parts.append(f"is farther from the recordings{where}{than}")
    if not parts:
        return ""
    end = ": were the two models given in the wrong order?" if everywhere else "."
    return f"The second model, {after}, {', and '.join(parts)}{end}"


def searched_model(content: Content) -> str:
    """Name of the model that was searched, that is, of the one that lacks what was found."""
    added = content.findings.added if content.findings is not None else ()
    first, second = ({instance.effect for instance in model.active.values()} for model in content.before_and_after)
    return content.names[1] if added and set(added) <= first - second else content.names[0]


def _farther(content: Content) -> tuple[list[str], bool]:
    """The main signals in which the later model is farther off, and whether it is closer in none of them."""
    times = closer(*content.given.comparisons[:2]).overall
    told = [name for name in content.given.headlines if name in times]
    farther = [name for name in told if times[name].times < _FARTHER]
    return farther, bool(farther) and all(times[name].times <= 1.0 for name in told)

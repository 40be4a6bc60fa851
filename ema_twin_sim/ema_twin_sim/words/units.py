"""Words about a unit's numbers and missing effects, the same on the terminal and on its page."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ..quantities import quantity
from .sentences import effect_words

if TYPE_CHECKING:
    from ..campaign.histories import Outlook
    from ..campaign.unit_health import JudgedTest, UnitHealth
    from ..campaign.units import Unit

LAST_ERROR = "last error / noise"
"""Heading of the largest error of a unit's last result, in times the sensors' noise."""
RESULT_HEAD = ("recording", "recorded", "task", "verdict", "missing", "error / noise", "reason")
"""Headings of a unit's results; the error is in times the sensors' noise."""
TEST_HEAD = ("test", "deviating", "distance / limit", "fault family", "what changed")
"""Headings of a unit's tests, compared with its healthy ones."""
_SHOWN = 3
"""Number of a unit's effects that are named."""


def number_words(look: Outlook) -> str:
    """A number's name: *backlash width*."""
    return f"{effect_words(look.history.owner)} {look.history.name.replace('_', ' ')}"


def change_of(look: Outlook) -> str:
    """By how much a number has changed: *+34 %*; empty if it has not."""
    if look.change is None:
        return ""
    if look.share is None:
        return f"by {quantity(look.now - look.healthy, look.history.unit)}"
    return f"{100.0 * look.share:+.3g} %".replace("-", "−")


def life_words(look: Outlook) -> str:
    """When a limit is reached: *40 to 90 days*, or *passed*; empty if no trend leads there."""
    if look.life is None:
        return ""
    if look.life.latest == 0.0:
        return "passed"
    unit = "days" if look.history.dated else "results"
    latest = f"{look.life.latest:.0f}" if math.isfinite(look.life.latest) else "∞"
    earliest = f"{look.life.earliest:.0f}"
    return f"{earliest} {unit}" if earliest == latest else f"{earliest} to {latest} {unit}"


def moving_words(looks: Sequence[Outlook]) -> list[str]:
    """The numbers of a unit that changed, and then those that a trend alone leads to their limit."""
    changed = [f"{number_words(look)} {change_of(look)}" for look in looks if look.change is not None]
    ending = [look for look in looks if look.change is None and look.life is not None]
    return changed + [f"{number_words(look)} {_end_words(look)}" for look in ending]


def _end_words(look: Outlook) -> str:
    passed = look.life is not None and look.life.latest == 0.0
    return "has passed its limit" if passed else f"reaches its limit in {life_words(look)}"


def _named_words(test: JudgedTest) -> str:
    """The fault family that a test's recordings give together: *play 97 %*; empty if none is off."""
    if not test.detected:
        return ""
    named = test.named
    return "unknown" if named is None else f"{named.family.value} {100.0 * named.probability:.0f} %"


def _change_words(test: JudgedTest) -> str:
    """What changed in the recording of a test that is farthest from the healthy ones, or why it could not be judged."""
    worst = test.worst
    if worst.detected is None:
        return " ".join(worst.words)
    return worst.words[len(worst.acquisition.findings)] if test.detected else ""


def health_words(health: UnitHealth | None) -> str:
    """In how many tests a unit differs from its healthy ones, and the fault family of the last of them."""
    if health is None or not health.baselines:
        return ""
    if not health.off:
        return f"like its healthy tests ({len(health.tests)} others)"
    last = health.off[-1]
    return f"{len(health.off)} of {len(health.tests)} tests deviate, the last {last.name}: {_named_words(last)}"


def missing_words(unit: Unit) -> str:
    """Which effects were missing in how many of a unit's results: *backlash 3/4*; empty if there was no search."""
    if not unit.searched:
        return ""
    told = [f"{effect_words(effect)} {count}/{unit.searched}" for effect, count in unit.missing[:_SHOWN]]
    more = len(unit.missing) - _SHOWN
    return ", ".join([*told, *([f"{more} more"] if more > 0 else [])]) or "nothing"


def result_cells(unit: Unit, row: Mapping[str, Any]) -> tuple[str, ...]:
    """One of a unit's results, below ``RESULT_HEAD``."""
    beyond = unit.beyond(row)
    return (
        row["name"],
        f"{row['time']:%Y-%m-%d %H:%M}" if row["time"] else "",
        row["task"],
        row["verdict"] or row["status"],
        ", ".join(effect_words(effect) for effect in row["missing"] or ()),
        "" if beyond is None else f"{beyond:.1f} ×",
        row["message"] or "",
    )


def test_cells(test: JudgedTest) -> tuple[str, ...]:
    """One of a unit's tests, below ``TEST_HEAD``."""
    distance = f"{test.worst.distance:.1f} ×" if test.judged else ""
    return test.name, f"{test.detected}/{test.judged}", distance, _named_words(test), _change_words(test)

"""Words about a unit's numbers and missing effects, the same on the terminal and on its page."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ..criteria import MOSTLY
from ..listing import number_of
from ..quantities import quantity
from .sentences import effect_words

if TYPE_CHECKING:
    from ..campaign.histories import Outlook
    from ..campaign.unit_health import JudgedTest, UnitHealth
    from ..campaign.units import Unit

LAST_ERROR = "error left / noise"
"""Heading of the largest error of a unit's last result, in times the sensors' noise."""
LAST_ERROR_IS = (
    f"{LAST_ERROR.capitalize()}: the largest error of a signal in the last recording that was judged, in times the "
    "sensors' noise: what is left once the missing effects are added and the numbers refitted (after campaign --do "
    "compare, the error of the model as it is)."
)
"""Explains that column: a unit that lacks an effect may have no more error left than a healthy one."""
RESULT_HEAD = ("recording", "recorded", "task", "verdict", "missing", "error left / noise", "reason")
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
    return _family(test) if named is None else f"{named.family.value} {100.0 * named.probability:.0f} %"


def _change_words(test: JudgedTest) -> str:
    """What changed in the recording of a test that is farthest from the healthy ones, or why it could not be judged.

    If no family of damage explains it, why.
    """
    worst = test.worst
    if worst.detected is None:
        return " ".join(worst.words)
    told = worst.words[len(worst.acquisition.findings) :]
    return " ".join(told if worst.unknown else told[:1]) if test.detected else ""


def health_words(health: UnitHealth | None) -> str:
    """In how many tests a unit differs from its healthy ones, and the fault family of the last of them."""
    if health is None or not health.baselines:
        return ""
    if not health.off:
        return f"like its healthy tests ({len(health.tests)} others)"
    last = health.off[-1]
    return f"{len(health.off)} of {len(health.tests)} tests deviate, the last {last.name}: {_named_words(last)}"


def fleet_words(
    units: Sequence[Unit], ahead: Mapping[str, Sequence[Outlook]], health: Mapping[str, UnitHealth | None]
) -> str:
    """What was found over all units, in words after their number; what was not looked for is left out."""
    told = []
    if any(unit.searched for unit in units):
        lacking = Counter(effect for unit in units for effect, _ in unit.missing)
        count = sum(bool(unit.missing) for unit in units)
        told.append(f"{count} with effects missing in their model{_counted(lacking, effect_words)}")
    if any(ahead.values()):
        changed = sum(bool(moving_words(looks)) for looks in ahead.values())
        told.append(f"{changed} with a parameter that changed or nears its limit")
    if judged := [of for of in health.values() if of is not None and of.tests]:
        off = sum(bool(of.off) for of in judged)
        told.append(f"{off} with tests that deviate from their healthy ones ({_of_tests(judged, 'tests')})")
    results = number_of(sum(unit.judged for unit in units), "result")
    refused = sum(unit.refused + unit.failed for unit in units)
    left = f"; {number_of(refused, 'input')} could not be judged" if refused else ""
    found = ", ".join(told) or "the errors of their model were computed, nothing else was looked for"
    return f"{found}. {results}{left}."


def counts_words(unit: Unit) -> str:
    """How many recordings of a unit were judged, refused, or failed."""
    return f"{number_of(unit.judged, 'result')}, {unit.refused} refused, {unit.failed} failed."


def unit_words(unit: Unit, looks: Sequence[Outlook], health: UnitHealth | None) -> list[str]:
    """What was found of one unit, a sentence each; what was not looked for is left out."""
    told = [counts_words(unit)]
    if unit.searched:
        told.append(f"Missing in its model: {missing_words(unit)}.")
    if health is not None and health.tests:
        told.append(f"{_of_tests([health], 'tests deviate from its healthy ones')}.")
        names = Counter(_family(test) for test in health.off)
        if names and max(names.values()) < MOSTLY * names.total():
            told.append("Its fault is named differently from test to test, so no single name is reliable.")
    if looks:
        moving = moving_words(looks)
        more = f", and {len(moving) - _SHOWN} more" if len(moving) > _SHOWN else ""
        told.append(f"Changed: {', '.join(moving[:_SHOWN])}{more}." if moving else "No parameter has changed.")
    return told


def _of_tests(health: Sequence[UnitHealth], tests: str) -> str:
    """How many tests deviate, and which families of faults they show: ``27 of 87 tests: local damage 20, play 7``."""
    families = Counter(_family(test) for of in health for test in of.off)
    every = [test for of in health for test in of.tests]
    left = sum(not test.judged for test in every)
    not_judged = f"; {left} could not be judged" if left else ""
    return f"{families.total()} of {len(every)} {tests}{_counted(families, str, ': ', '')}{not_judged}"


def _family(test: JudgedTest) -> str:
    return "unknown" if (of := test.named) is None else of.family.value


def _counted(counts: Counter[str], words: Callable[[str], str], begin: str = " (", end: str = ")") -> str:
    """How often each occurs, the most frequent first and a few only; empty if there are none."""
    told = [f"{words(name)} {count}" for name, count in counts.most_common(_SHOWN)]
    more = [f"{len(counts) - _SHOWN} other"] if len(counts) > _SHOWN else []
    return f"{begin}{', '.join([*told, *more])}{end}" if told else ""


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

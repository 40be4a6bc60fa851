"""Words about a unit's health, test by test: the same on the terminal and on its page."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..listing import number_of
from ..quantities import estimate

if TYPE_CHECKING:
    from ..campaign.histories import Outlook
    from ..campaign.unit_health import JudgedTest, UnitHealth

TEST_HEAD = ("test", "deviating", "distance / limit", "fault family", "what changed")
"""Headings of a unit's tests, compared with its healthy ones."""
MONTH = 30.0  # days
_SHOWN = 3
"""Number of fault families that are named."""


def health_words(health: UnitHealth | None) -> str:
    """In how many tests a unit differs from its healthy ones and since when, and the fault family of the last of them.

    Empty if its health was not asked for.
    """
    if health is None:
        return ""
    if not health.baselines:
        return "not judged"
    if not health.tests:
        return "not judged: all its tests are healthy ones"
    if not health.off:
        return f"like its healthy tests ({number_of(len(health.tests), 'other')})"
    last = health.off[-1]
    return f"{len(health.off)} of {len(health.tests)} tests deviate, {_when_words(health)}: {_named_words(last)}"


def _when_words(health: UnitHealth) -> str:
    """Since when all tests deviate, or which was the last that did."""
    if not health.lasting:
        return f"the last {health.off[-1].name}, none since"
    begun = f"since {health.lasting[0].name}"
    if len(health.lasting) > 1:
        return f"all {begun}"
    return begun if len(health.off) == 1 else f"again {begun}"


def tests_words(health: Sequence[UnitHealth], tests: str) -> str:
    """How many tests deviate, and how many of them show which family of faults: ``27 of 87 tests: play 20, load 7``."""
    families = Counter(family_words(test) for of in health for test in of.off)
    told = [f"{family} {count}" for family, count in families.most_common(_SHOWN)]
    others = families.total() - sum(count for _, count in families.most_common(_SHOWN))
    told += [number_of(others, "other")] if others else []
    every = [test for of in health for test in of.tests]
    left = sum(not test.judged for test in every)
    not_judged = f"; {left} could not be judged" if left else ""
    return f"{families.total()} of {len(every)} {tests}{': ' if told else ''}{', '.join(told)}{not_judged}"


def family_words(test: JudgedTest) -> str:
    """The fault family that a test's recordings give together, or *unknown*."""
    return "unknown" if (of := test.named) is None else of.family.value


def course_words(look: Outlook) -> str:
    """How far a feature is from the healthy tests, and how it changes: *friction: 24 standard deviations above …*."""
    of, trend = look.history, look.trend
    last = float(of.values[-1])
    told = (
        f"{feature_words(look)}: in the last test {abs(last):.{0 if abs(last) > 10.0 else 1}f} standard deviations "
        f"{'above' if last > 0.0 else 'below'} the healthy"
    )
    if trend is None:
        return f"{told}, without a trend" if of.dated else told
    slope = estimate(abs(trend.slope) * MONTH, trend.slope_error * MONTH, "1")
    return f"{told}, {'rising' if trend.slope > 0.0 else 'falling'} by {slope} a month"


def feature_words(look: Outlook) -> str:
    """A feature's name: *fast roughness*."""
    return look.history.name.replace("_", " ")


def test_cells(test: JudgedTest) -> tuple[str, ...]:
    """One of a unit's tests, below ``TEST_HEAD``."""
    distance = f"{test.worst.distance:.1f} ×" if test.judged else ""
    return test.name, f"{test.detected}/{test.judged}", distance, _named_words(test), _change_words(test)


def _named_words(test: JudgedTest) -> str:
    """The fault family that a test's recordings give together: *play 97 %*; empty if none is off."""
    if not test.detected:
        return ""
    named = test.named
    return family_words(test) if named is None else f"{named.family.value} {100.0 * named.probability:.0f} %"


def _change_words(test: JudgedTest) -> str:
    """What changed in the recording of a test that is farthest from the healthy ones, or why it could not be judged.

    If no family of damage explains what changed in all of them together, why.
    """
    worst = test.worst
    if worst.detected is None:
        return " ".join(worst.words)
    told = worst.words[len(worst.acquisition.findings) :]
    return " ".join((*told[:1], *((test.why,) if test.named is None else ()))) if test.detected else ""

"""Words about a unit's health, test by test: the same on the terminal and on its page."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from ..campaign.histories import Outlook
from ..campaign.unit_health import JudgedTest, UnitHealth
from ..health.judgement import changed_words
from ..listing import number_of
from ..quantities import estimate
from .unit_results import DISTANCE, first_clause

TEST_HEAD = ("test", "deviating", DISTANCE, "fault family", "what changed")
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
        return f"not judged: {first_clause(health.remarks[0])}" if health.remarks else "not judged"
    if not health.tests:
        return "not judged: all its tests are healthy ones"
    left, others = len(health.tests) - len(health.judged), number_of(len(health.judged), "other")
    if not health.off:
        if health.blind:
            return f"{blind_words(health)}{f'; before, like its healthy tests ({others})' if health.judged else ''}"
        return f"like its healthy tests ({others}{f'; {left} could not be judged' if left else ''})"
    told = (
        f"{len(health.off)} of {len(health.tests)} tests deviate, {_when_words(health)}: {_named_words(health.off[-1])}"
    )
    return f"{told}; {blind_words(health)}" if health.blind else told


def blind_words(health: UnitHealth) -> str:
    """How many of a unit's last tests could not be judged, and why the last one could not; empty if it could."""
    blind = health.blind
    if not blind:
        return ""
    if len(blind) == len(health.tests):
        which = f"none of its {number_of(len(blind), 'test')} could"
    else:
        which = f"its last {number_of(len(blind), 'test') if len(blind) > 1 else 'test'} could not"
    return f"{which} be judged ({first_clause(blind[-1].reason)})"


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
        f"{of.name.replace('_', ' ')}: in the last test {abs(last):.{0 if abs(last) > 10.0 else 1}f} standard "
        f"deviations {'above' if last > 0.0 else 'below'} the healthy"
    )
    if trend is None:
        since = f" since {of.names[look.change.begin]}" if look.change else ""
        return f"{told}, without a trend{since}" if of.dated else told
    slope = estimate(abs(trend.slope) * MONTH, trend.slope_error * MONTH, "1")
    return f"{told}, {'rising' if trend.slope > 0.0 else 'falling'} by {slope} a month"


def test_cells(test: JudgedTest) -> tuple[str, ...]:
    """One of a unit's tests, below ``TEST_HEAD``."""
    distance = f"{test.worst.distance:.1f} ×" if test.judged else ""
    counts = f"{test.detected}/{test.judged}" if test.judged else "not judged"
    return test.name, counts, distance, _named_words(test), _change_words(test)


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
    if not test.detected:
        return ""
    said = changed_words(worst.changes)
    why = test.why if test.named is None else ""
    return f"{said[:1].upper()}{said[1:]}. {why}".rstrip()


def naming_words(health: UnitHealth) -> str:
    """How the fault family of the last test that deviates was found, and what to look at; empty if none deviates.

    What no family explains is told with what changed.
    """
    if not health.off or health.off[-1].named is None:
        return ""
    return f"Test {health.off[-1].name}: {health.off[-1].why}"

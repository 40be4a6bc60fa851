"""Words about a unit's numbers and missing effects, and about a fleet: the same on the terminal and on its page."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence

from ..campaign.histories import Outlook
from ..campaign.unit_health import UnitHealth
from ..campaign.units import Unit
from ..criteria import MOSTLY
from ..listing import number_of
from ..quantities import quantity
from .sentences import effect_words
from .unit_health import blind_words, family_words, health_words, tests_words
from .unit_results import LAST_ERROR

LAST_ERROR_IS = (
    f"{LAST_ERROR.capitalize()}: the largest error of a signal in the last recording that was judged, in times the "
    "sensors' noise: what is left once the missing effects are added and the numbers refitted (after campaign --do "
    "compare, the error of the model as it is)."
)
"""Explains that column: a unit that lacks an effect may have no more error left than a healthy one."""
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


def fleet_words(
    units: Sequence[Unit], ahead: Mapping[str, Sequence[Outlook]], health: Mapping[str, UnitHealth | None]
) -> str:
    """What was found over all units, in words after their number; what was not looked for is left out."""
    told = []
    if any(unit.searched for unit in units):
        count = sum(bool(unit.missing) for unit in units)
        told.append(f"{count} with effects missing in their model{_lacked_words(units)}")
    if any(ahead.values()):
        changed = sum(bool(moving_words(looks)) for looks in ahead.values())
        told.append(f"{changed} with a parameter that changed or nears its limit")
    if judged := [of for of in health.values() if of is not None and of.tests]:
        off = sum(bool(of.off) for of in judged)
        told.append(f"{off} with tests that deviate from their healthy ones ({tests_words(judged, 'tests')})")
        if blind := sum(bool(of.blind) for of in judged):
            told.append(f"{blind} whose last test could not be judged")
    elif any(health.values()):
        told.append("none could be compared with healthy recordings of its own")
    refused = sum(unit.refused + unit.failed for unit in units)
    judged_results = sum(unit.judged for unit in units)
    if not judged_results:
        whose = "their" if len(units) > 1 else "its"
        return f"none of {whose} {number_of(refused, 'input')} could be judged; --unit NAME tells why."
    left = f"; {number_of(refused, 'input')} could not be judged" if refused else ""
    found = ", ".join(told) or "the errors of their model were computed, nothing else was looked for"
    return f"{found}. {number_of(judged_results, 'result')}{left}."


def order_words(units: Sequence[Unit], health: Mapping[str, UnitHealth | None]) -> str:
    """By what the units are sorted."""
    if any(health.values()):
        blind = any(of is not None and of.blind for of in health.values())
        then = ", then those whose last test could not be judged" if blind else ""
        last = "last judged test" if blind else "last test"
        return f"those whose {last} deviates first{then}, then by their share of deviating tests"
    errors = any(unit.beyond_noise is not None for unit in units)
    return f"the largest {LAST_ERROR} first" if errors else "by name"


def looked_for(
    units: Sequence[Unit],
    ahead: Mapping[str, Sequence[Outlook]],
    health: Mapping[str, UnitHealth | None],
    changed: Callable[[Sequence[Outlook]], str],
) -> dict[str, list[str]]:
    """Columns of what was found: each heading with one cell for each unit, without what was not looked for."""
    columns: dict[str, list[str]] = {}
    if any(unit.searched for unit in units):
        columns["missing effects (results)"] = [missing_words(unit) for unit in units]
    if any(unit.beyond_noise is not None for unit in units):
        times = [unit.beyond_noise for unit in units]
        columns[LAST_ERROR] = ["" if of is None else f"{of:.1f} ×" for of in times]
    if any(ahead.values()):
        columns["changed"] = [changed(ahead[unit.name]) for unit in units]
    if any(health.values()):
        columns["health"] = [health_words(health[unit.name]) for unit in units]
    return columns


def counts_words(unit: Unit) -> str:
    """How many recordings of a unit were judged, refused, or failed, and how many were left out of their unit."""
    left_out = f", {number_of(unit.left_out, 'recording')} left out" if unit.left_out else ""
    return f"{number_of(unit.judged, 'result')}, {unit.refused} refused, {unit.failed} failed{left_out}."


def unit_words(unit: Unit, looks: Sequence[Outlook], health: UnitHealth | None) -> list[str]:
    """What was found of one unit, a sentence each; what was not looked for is left out."""
    told = [counts_words(unit)]
    if unit.searched:
        told.append(f"Missing in its model: {missing_words(unit)}.")
    if health is not None and health.tests:
        told.append(f"{tests_words([health], 'tests deviate from its healthy ones')}.")
        if health.blind:
            said = blind_words(health)
            told.append(f"{said[:1].upper()}{said[1:]}.")
        names = Counter(family_words(test) for test in health.off)
        if names and max(names.values()) < MOSTLY * names.total():
            told.append("Its fault is named differently from test to test, so no single name is reliable.")
    if looks:
        moving = moving_words(looks)
        more = f", and {len(moving) - _SHOWN} more" if len(moving) > _SHOWN else ""
        told.append(f"Changed: {', '.join(moving[:_SHOWN])}{more}." if moving else "No parameter has changed.")
    return told


def _lacked_words(units: Sequence[Unit]) -> str:
    """How many units lack which effects, the most frequent first and a few only: *(backlash 16, 2 other effects)*."""
    counts = Counter(effect for unit in units for effect, _ in unit.missing)
    told = [f"{effect_words(effect)} {count}" for effect, count in counts.most_common(_SHOWN)]
    more = len(counts) - _SHOWN
    told += [number_of(more, "other effect")] if more > 0 else []
    return f" ({', '.join(told)})" if told else ""


def missing_words(unit: Unit) -> str:
    """Which effects were missing in how many of a unit's results: *backlash 3/4*; empty if there was no search."""
    if not unit.searched:
        return ""
    told = [f"{effect_words(effect)} {count}/{unit.searched}" for effect, count in unit.missing[:_SHOWN]]
    more = len(unit.missing) - _SHOWN
    return ", ".join([*told, *([f"{more} more"] if more > 0 else [])]) or "nothing"

"""The fleet: a folder of self-contained pages, one of all units and one for each unit.

A unit's page follows ISO 13374: acquisition, the unit's state, its health, prognosis, advice.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from urllib.parse import quote

from ema_bench_replay.outputs import write_text

from ..campaign.feature_courses import feature_courses
from ..campaign.histories import Outlook
from ..campaign.jobs import HEALTH
from ..campaign.store import file_name
from ..campaign.unit_health import UnitHealth
from ..campaign.units import Unit
from ..listing import number_of
from ..quantities import estimate, quantity
from ..words.unit_health import TEST_HEAD, course_words, health_words, test_cells
from ..words.unit_results import LAST_ERROR, NUMBERS, result_columns
from ..words.units import (
    LAST_ERROR_IS,
    change_of,
    counts_words,
    fleet_words,
    life_words,
    looked_for,
    missing_words,
    moving_words,
    number_words,
    order_words,
)
from .history_chart import history_chart
from .markup import Markup, capitalised, items, joined, section, table, tag
from .whole_page import whole_page

_UNITS = "units"
_FILTER = (
    "const box=document.querySelector('input');"
    "box.addEventListener('input',()=>{for(const row of document.querySelectorAll('tbody tr'))"
    "row.hidden=!row.textContent.toLowerCase().includes(box.value.toLowerCase())})"
)


def write_fleet(
    folder: Path,
    units: Sequence[Unit],
    ahead: Mapping[str, Sequence[Outlook]],
    health: Mapping[str, UnitHealth | None],
    remarks: Sequence[str] = (),
    *,
    force: bool = False,
    done: Callable[[str], None] = lambda unit: None,
) -> Path:
    """Write the pages; return the path of the one of all units, which says the remarks on several units.

    ``done`` is called with each unit whose page is written.
    Raises InputError if it exists (without ``force``) or cannot be written.
    """
    overview = folder / "index.html"
    write_text(overview, _overview(units, ahead, health, remarks), force=force)
    for unit in units:
        write_text(folder / _UNITS / _file(unit), _unit(unit, ahead[unit.name], health[unit.name]), force=True)
        done(unit.name)
    return overview


def _file(unit: Unit) -> str:
    return f"{file_name(unit.name)}.html"


def _overview(
    units: Sequence[Unit],
    ahead: Mapping[str, Sequence[Outlook]],
    health: Mapping[str, UnitHealth | None],
    remarks: Sequence[str],
) -> str:
    columns = looked_for(units, ahead, health, lambda looks: ", ".join(moving_words(looks)))
    rows = [
        (
            tag("a", unit.name, href=quote(f"{_UNITS}/{_file(unit)}")),
            str(unit.judged),
            str(unit.refused + unit.failed or ""),
            f"{unit.last:%Y-%m-%d}" if unit.last else "",
            *cells,
        )
        for unit, *cells in zip(units, *columns.values(), strict=True)
    ]
    head = ("unit", "judged", "not judged", "last recorded", *columns)
    found = table(head, rows, words=(0, *(k for k in range(3, len(head)) if head[k] != LAST_ERROR)))
    box = tag("p", tag("label", "Show units with ", Markup('<input type="search" aria-label="filter">')))
    said = [items(*map(capitalised, remarks))] if remarks else []
    notes = [tag("p", f"{capitalised(order_words(units, health))}.", class_="aside")]
    notes += [tag("p", LAST_ERROR_IS, class_="aside")] if LAST_ERROR in columns else []
    title = number_of(len(units), "unit")
    body = joined(
        [tag("h1", title), tag("p", fleet_words(units, ahead, health), class_="lead"), *said, box, found, *notes]
    )
    return whole_page(title, body, script=_FILTER)


def _unit(unit: Unit, looks: Sequence[Outlook], health: UnitHealth | None) -> str:
    changed = [look for look in looks if look.change is not None]
    remarks = [*unit.remarks, *(() if health is None else health.remarks)]
    courses = feature_courses(unit, health)
    deviations = "in standard deviations of the healthy tests"
    features = (_figure(look, f"{look.history.name.replace('_', ' ')}, {deviations}") for look in courses)
    of_model = [] if _health_alone(unit) else _of_model(unit, looks, changed)
    leading = [look for look in looks if look.life is not None or look.trend is not None]
    results = result_columns(unit, health)
    words = tuple(k for k, heading in enumerate(results) if heading not in NUMBERS)
    parts = (
        tag("h1", unit.name),
        tag("p", tag("a", "all units", href="../index.html")),
        section(
            "acquisition",
            "Acquisition",
            tag("p", counts_words(unit)),
            items(*remarks) if remarks else tag("p", "All results can be compared with each other."),
        ),
        section("state", "State", tag("p", _state(unit, health)), *_tests(health)),
        section(
            "health",
            "Health",
            *of_model,
            *([] if health is None else [tag("p", f"Its health: {health_words(health)}.")]),
            tag("div", *(_figure(look, _number_caption(look)) for look in looks), *features, class_="grid"),
        ),
        section("prognosis", "Prognosis", _prognosis(unit, leading, courses)),
        section("advice", "Advice", items(*_advice(unit, changed, leading, health))),
        section("results", "Results", table(tuple(results), zip(*results.values(), strict=True), words=words)),
    )
    return whole_page(unit.name, joined(parts))


def _health_alone(unit: Unit) -> bool:
    """Whether only the unit's health was asked for: then nothing is said of its model."""
    return all(row["task"] == HEALTH for row in unit.rows)


def _of_model(unit: Unit, looks: Sequence[Outlook], changed: Sequence[Outlook]) -> list[Markup]:
    """What its model lacks, and which parameters changed."""
    return [
        tag("p", f"Missing in its model: {missing_words(unit) or 'not looked for'}."),
        items(*map(_changed, changed)) if changed else tag("p", _unchanged(looks)),
    ]


def _prognosis(unit: Unit, leading: Sequence[Outlook], courses: Sequence[Outlook]) -> Markup:
    """Where its numbers and the features of its health lead."""
    if leading or courses:
        return items(*map(_leads, leading), *(f"{capitalised(course_words(look))}." for look in courses))
    return tag("p", "No test deviates, so no trend is followed." if _health_alone(unit) else "No number shows a trend.")


def _state(unit: Unit, health: UnitHealth | None) -> str:
    if unit.beyond_noise is None and not unit.judged:
        return "None of its inputs could be judged."
    if unit.beyond_noise is None and health is not None:
        return "Its recordings were compared with its healthy ones, and with no model."
    if unit.beyond_noise is None:
        return "No error of its model was computed."
    if unit.beyond_noise <= 1.0:
        return "In its last result, all errors are within the sensors' noise."
    return f"In its last result, the largest error is {unit.beyond_noise:.1f} times the sensors' noise."


def _tests(health: UnitHealth | None) -> Iterator[Markup]:
    """How a unit's tests compare with its healthy ones."""
    if health is None or not health.tests:
        return
    for one in health.baselines:
        yield tag("p", f"Compared with {one.runs} healthy recordings of {one.tests} tests:")
    yield table(TEST_HEAD, map(test_cells, health.tests), words=(0, 3, 4))


def _unchanged(looks: Sequence[Outlook]) -> str:
    if not looks:
        return "There are too few results with standard errors to follow a parameter."
    if any(look.trend is not None for look in looks):
        return "No parameter has left its healthy values, but these have a trend of their own: see below."
    return "No parameter has changed."


def _changed(look: Outlook) -> str:
    assert look.change is not None  # the caller passes only those
    levels = f"{quantity(look.healthy, look.history.unit)} to {quantity(look.now, look.history.unit)}"
    since = look.history.names[look.change.begin]
    return f"{number_words(look)} went from {levels} ({change_of(look)}); it has changed since {since}."


def _leads(look: Outlook) -> str:
    of, by = look.history, "day" if look.history.dated else "result"
    told = []
    if look.trend is not None:
        slope = estimate(look.trend.slope, look.trend.slope_error, of.unit)
        told.append(f"{number_words(look)} changes by {slope} per {by}.")
    if look.life is not None and look.life.latest == 0.0:
        told.append(f"{number_words(look)} has passed its limit.")
    elif look.life is not None:
        told.append(f"It reaches its limit in {life_words(look)} (90 %).")
    return " ".join(told)


def _advice(unit: Unit, changed: Sequence[Outlook], leading: Sequence[Outlook], health: UnitHealth | None) -> list[str]:
    ending = [look for look in leading if look.life is not None and math.isfinite(look.life.median)]
    told = [
        f"Repair it: {number_words(look)} has passed its limit."
        if look.life is not None and look.life.latest == 0.0
        else f"Plan its maintenance: {number_words(look)} reaches its limit in {life_words(look)}."
        for look in ending
    ]
    told += [f"Find out why {number_words(look)} has changed ({change_of(look)})." for look in changed[:3]]
    if health is not None and health.off:
        told.append(health.off[-1].why)
    if health is not None and health.blind:
        told.append(f"How it is now is not known. {health.blind[-1].reason}")
    if unit.missing:
        told.append("Add what is missing to its model, and follow its numbers: campaign --do fit.")
    if unit.refused + unit.failed:
        told.append("See below why inputs could not be judged.")
    return told or ["Nothing to do."]


def _number_caption(look: Outlook) -> str:
    of = look.history
    last = estimate(float(of.values[-1]), float(of.errors[-1]), of.unit)
    return f"{number_words(look)}: healthy {quantity(look.healthy, of.unit)}, last {last}"


def _figure(look: Outlook, caption: str) -> Markup:
    return tag("figure", tag("figcaption", caption), history_chart(look))

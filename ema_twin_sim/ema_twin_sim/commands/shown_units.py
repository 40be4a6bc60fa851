"""What ``ema-twin units`` prints: the table of all units, and one unit's tests, parameters and results."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rich.markup import escape

from ..campaign.histories import Outlook
from ..campaign.unit_health import UnitHealth
from ..campaign.units import Unit
from ..listing import number_of
from ..quantities import estimate, quantity
from ..words.unit_health import MONTH, TEST_HEAD, course_words, naming_words, test_cells
from ..words.unit_results import LAST_ERROR, NUMBERS, result_columns
from ..words.units import LAST_ERROR_IS, change_of, life_words, looked_for, moving_words, number_words, order_words
from .output import console, say
from .tables import ReportTable


def show_units(
    units: Sequence[Unit],
    ahead: Mapping[str, Sequence[Outlook]],
    health: Mapping[str, UnitHealth | None],
    most: int | None,
) -> None:
    """Print one row for each unit, ``most`` and all whose health deviates or is not known.

    Columns of what was not looked for are left out.
    """
    columns = looked_for(units, ahead, health, _changed)
    if most is not None:
        most = max(most, sum(of is not None and of.conspicuous for of in health.values()))
    table = ReportTable(f"{_shown_of(len(units), most, 'unit')}, {order_words(units, health)}")
    table.words("unit")
    table.numbers("judged", "refused", "failed")
    table.words("last recorded")
    for heading in columns:
        if heading == LAST_ERROR:
            table.numbers(heading)
        else:
            table.words(heading, widest=40)
    for one, *found in list(zip(units, *columns.values(), strict=True))[:most]:
        table.add_row(
            escape(one.name),
            str(one.judged),
            str(one.refused or ""),
            str(one.failed or ""),
            f"{one.last:%Y-%m-%d}" if one.last else "",
            *map(escape, found),
        )
    console.print(table)
    say(f"{LAST_ERROR_IS if LAST_ERROR in columns else ''} --unit NAME shows all recordings.".strip())


def _changed(looks: Sequence[Outlook]) -> str:
    """The number of a unit that changed most, or that reaches its limit, and how many others do."""
    moving = moving_words(looks)
    others = f", {len(moving) - 1} more" if len(moving) > 1 else ""
    return f"{moving[0]}{others}" if moving else ""


def _shown_of(count: int, most: int | None, one: str, which: str = "first") -> str:
    """How many of ``count`` rows a table shows: ``3 units``, or ``the first 40 of 350 units (--all shows all)``."""
    if most is None or count <= most:
        return number_of(count, one)
    return f"the {which} {most} of {number_of(count, one)} (--all shows all)"


def show_recordings(one: Unit, health: UnitHealth | None, most: int | None) -> None:
    """Print the results of a unit, at most the last ``most``."""
    table = ReportTable(f"\n{one.name}: {_shown_of(len(one.rows), most, 'result', 'last')}")
    columns = result_columns(one, health)
    for heading in columns:
        table.numbers(heading) if heading in NUMBERS else table.words(heading)
    for cells in list(zip(*columns.values(), strict=True))[-most if most else 0 :]:
        table.add_row(*map(escape, cells))
    console.print(table)


def show_health(health: UnitHealth | None, courses: Sequence[Outlook], most: int | None) -> None:
    """Print how a unit's tests differ from its healthy ones, and how; of more than ``most`` tests, the farthest."""
    if health is None or not health.tests:
        return
    for one in health.baselines:
        say(
            f"\nHealth, compared with {one.runs} healthy recordings of {one.tests} tests. Expected false alarms: "
            f"{100.0 * one.false_alarm:g} %; among these recordings, each judged without its own test: "
            f"{100.0 * one.false_alarms_left_out:.0f} %."
        )
    tests = health.tests
    if most is not None and len(tests) > most:
        farthest = sorted(tests, key=lambda test: -test.worst.distance if test.judged else 0.0)[:most]
        tests = tuple(test for test in tests if test in farthest)
    table = ReportTable(_shown_of(len(health.tests), most, "test", "farthest"))
    table.words(TEST_HEAD[0])
    table.numbers(*TEST_HEAD[1:3])
    table.words(*TEST_HEAD[3:])
    for test in tests:
        table.add_row(*map(escape, test_cells(test)))
    console.print(table)
    say("Distance: the largest distance from the healthy recordings, in times the limit.")
    if named := naming_words(health):
        say(named)
    for look in courses:
        said = course_words(look)
        say(f"{said[:1].upper()}{said[1:]}.")


def show_numbers(looks: Sequence[Outlook], most: int | None) -> None:
    """Print how the numbers of a unit change, those that changed most first, at most ``most``."""
    if not looks:
        return
    told = _shown_of(len(looks), most, "parameter")
    table = ReportTable(
        f"\n{told[:1].upper()}{told[1:]} over time: healthy value, last value, change, and when it began"
    )
    table.words("parameter")
    table.numbers("healthy", "last", "change")
    table.words("since")
    table.numbers("trend", "to the limit", "reaches it in")
    for look in looks[:most]:
        of = look.history
        slope = None if look.trend is None else look.trend.slope * (MONTH if of.dated else 1.0)
        table.add_row(
            escape(number_words(look)),
            quantity(look.healthy, of.unit),
            estimate(float(of.values[-1]), float(of.errors[-1]), of.unit),
            escape(change_of(look)),
            escape(of.names[look.change.begin]) if look.change else "",
            "none" if slope is None else f"{quantity(slope, of.unit)} a {'month' if of.dated else 'result'}",
            "" if look.margin is None else f"{100.0 * look.margin.share:.0f} %",
            life_words(look),
        )
    console.print(table)

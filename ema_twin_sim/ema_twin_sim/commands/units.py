"""``ema-twin units``: a campaign's results, one row per unit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated

import typer
from rich.markup import escape

from ..listing import number_of
from ..quantities import estimate, quantity
from ..words.units import (
    LAST_ERROR,
    LAST_ERROR_IS,
    RESULT_HEAD,
    TEST_HEAD,
    change_of,
    fleet_words,
    health_words,
    life_words,
    missing_words,
    moving_words,
    number_words,
    result_cells,
    test_cells,
    unit_words,
)
from . import options
from .output import console, say, warn
from .rerun_file import check_rrd_name, tell_of_rrd
from .tables import ReportTable

if TYPE_CHECKING:
    from ..campaign.histories import Outlook
    from ..campaign.unit_health import UnitHealth
    from ..campaign.units import Unit

EXAMPLES = """Examples:

ema-twin units results

ema-twin units results --json units.json

ema-twin units results --unit EMA-007     (its recordings, one by one, and how its numbers change)

ema-twin units results --page fleet     (then open fleet/index.html)

ema-twin units results --limits limits.yaml --healthy 10     (limits.yaml: backlash.width: 0.004)

ema-twin units results --unit EMA-007 --rrd history.rrd

ema-twin units results --unit rig --healthy "^normal"     (after campaign --do health: what its other tests are like)"""

_MONTH = 30.0  # days
_ROWS = 20
"""Rows of a table that are shown unless all are asked for."""


def run(
    results: Annotated[Path, typer.Argument(metavar="RESULTS", help="The folder that campaign wrote.")],
    unit: Annotated[
        str | None, typer.Option("--unit", metavar="NAME", help="Show each recording of this unit.")
    ] = None,
    limits: Annotated[
        Path | None,
        typer.Option("--limits", metavar="FILE.yaml", help="Limits of numbers, in SI units: backlash.width: 0.004"),
    ] = None,
    healthy: Annotated[
        str | None,
        typer.Option(
            "--healthy",
            metavar="N|PATTERN",
            help="Which results of each unit are healthy: the first N, or those whose name matches a regular "
            "expression; by default the first third.",
        ),
    ] = None,
    page: Annotated[
        Path | None,
        typer.Option("--page", metavar="FOLDER", help="Also write pages: FOLDER/index.html, and one of each unit."),
    ] = None,
    whole: Annotated[
        bool, typer.Option("--all", help="Show all rows of the tables, however many; by default the most telling.")
    ] = False,
    rrd: Annotated[
        Path | None,
        typer.Option("--rrd", metavar="FILE.rrd", help="Also write the history of --unit as views for rerun."),
    ] = None,
    force: options.Force = False,
    json: options.JsonFile = None,
) -> None:
    """Show which unit misses which effect, how far its recordings are off, and which of its numbers change.

    If a parameter has left the range of its healthy values, the recording where that began is shown; if it has a trend
    and a limit, also when it reaches the limit.
    """
    from ema_bench_replay.errors import InputError

    from ..campaign.healthy import Healthy
    from ..campaign.histories import FEWEST_HEALTHY, outlooks, read_limits
    from ..campaign.store import Store
    from ..campaign.unit_health import unit_health
    from ..campaign.units import units_of
    from ..model.model import nearest
    from .inputs import write_json

    check_rrd_name(rrd)
    if rrd is not None and unit is None:
        raise InputError(f"--rrd {rrd}: shows one unit; name it with --unit")
    of_numbers = read_limits(limits)
    known_good = Healthy.of(healthy, FEWEST_HEALTHY)
    found = units_of(Store.opened(results).rows())
    names = tuple(one.name for one in found)
    if known_good.pattern and not any(known_good.pattern.search(row["name"]) for one in found for row in one.rows):
        some = next((row["name"] for one in found for row in one.rows), "")
        raise InputError(
            f"--healthy {healthy}: no result has a name with that, as '{some}' is one; correct the pattern"
        )
    if unit is not None:
        found = [one for one in found if one.name == unit]
        if not found:
            raise InputError(
                f"{results}: holds no unit '{unit}'; {nearest(unit, names)} (all: ema-twin units {quote(str(results))})"
            )
    ahead = {one.name: outlooks(one, of_numbers, known_good) for one in found}
    health = {one.name: unit_health(one, known_good) for one in found}
    followed = tuple(dict.fromkeys(look.history.path for looks in ahead.values() for look in looks))
    for path in (path for path in of_numbers if path not in followed):
        hint = f"; {nearest(path, followed)}" if followed else ""
        warn(f"{limits}: none of these units has a history of {path}{hint}")
    most = None if whole else _ROWS
    if unit is not None:
        say(f"{unit}: {' '.join(unit_words(found[0], ahead[unit], health[unit]))}")
        _show_health(health[unit], most)
        _show_numbers(ahead[unit], most)
        _show_recordings(found[0], most)
    else:
        say(f"{number_of(len(found), 'unit')}: {fleet_words(found, ahead, health)}")
        _show(found, ahead, health, most)
    for one in found:
        if not all(look.history.as_asked for look in ahead[one.name]):
            warn(
                f"{one.name}: some of its parameters are compared with their first "
                f"{'third' if known_good.pattern else f'{FEWEST_HEALTHY} values or days'}, because --healthy {healthy} "
                f"selects fewer than {FEWEST_HEALTHY} of their values or days"
            )
        for remark in one.remarks:
            warn(f"{one.name}: {remark}")
        for remark in () if (of := health[one.name]) is None else of.remarks:
            warn(f"{one.name}: {remark}")
    if rrd is not None and unit is not None:
        from ..views.unit_history import write_unit_history

        if not ahead[unit] and health[unit] is None:
            raise InputError(f"--rrd {rrd}: too few results of {unit} have numbers, and none has health")
        tell_of_rrd(rrd, write_unit_history(rrd, ahead[unit], health[unit], force=force))
    if page is not None:
        from ..report.fleet import write_fleet

        overview = write_fleet(page, found, ahead, health, force=force)
        say(f"{overview}: open it in any browser")
    write_json(json, [_json(one, ahead[one.name], health[one.name]) for one in found])


def _json(one: Unit, looks: Sequence[Outlook], health: UnitHealth | None) -> dict[str, object]:
    return {
        **one.as_json(),
        "numbers": [look.as_json() for look in looks],
        "health": None if health is None else health.as_json(),
    }


def _show(
    units: Sequence[Unit],
    ahead: Mapping[str, Sequence[Outlook]],
    health: Mapping[str, UnitHealth | None],
    most: int | None,
) -> None:
    """Print one row for each unit, at most ``most``."""
    table = ReportTable(f"{_shown_of(len(units), most, 'unit')}, the largest {LAST_ERROR} first")
    table.words("unit")
    table.numbers("judged", "refused", "failed")
    table.words("last recorded", "missing effects (results)")
    table.numbers(LAST_ERROR)
    table.words("changed", widest=40)
    judged = any(health.values())
    if judged:
        table.words("health", widest=40)
    for one in units[:most]:
        table.add_row(
            escape(one.name),
            str(one.judged),
            str(one.refused or ""),
            str(one.failed or ""),
            f"{one.last:%Y-%m-%d}" if one.last else "",
            missing_words(one),
            "" if one.beyond_noise is None else f"{one.beyond_noise:.1f} ×",
            _changed(ahead[one.name]),
            *([escape(health_words(health[one.name]))] if judged else []),
        )
    console.print(table)
    say(f"{LAST_ERROR_IS} --unit NAME shows all recordings.")


def _changed(looks: Sequence[Outlook]) -> str:
    """The number of a unit that changed most, or that reaches its limit, and how many others do."""
    moving = moving_words(looks)
    others = f", {len(moving) - 1} more" if len(moving) > 1 else ""
    return escape(f"{moving[0]}{others}") if moving else ""


def _shown_of(count: int, most: int | None, one: str, which: str = "first") -> str:
    """How many of ``count`` rows a table shows: ``3 units``, or ``the first 40 of 350 units (--all shows all)``."""
    if most is None or count <= most:
        return number_of(count, one)
    return f"the {which} {most} of {number_of(count, one)} (--all shows all)"


def _show_recordings(one: Unit, most: int | None) -> None:
    """Print the results of a unit, at most the last ``most``."""
    table = ReportTable(f"\n{one.name}: {_shown_of(len(one.rows), most, 'result', 'last')}")
    table.words(*RESULT_HEAD[:5])
    table.numbers(RESULT_HEAD[5])
    table.words(RESULT_HEAD[6])
    for row in one.rows[-most if most else 0 :]:
        table.add_row(*map(escape, result_cells(one, row)))
    console.print(table)


def _show_health(health: UnitHealth | None, most: int | None) -> None:
    """Print how a unit's tests differ from its healthy ones; of more than ``most``, the farthest."""
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


def _show_numbers(looks: Sequence[Outlook], most: int | None) -> None:
    """Print how the numbers of a unit change, those that changed most first, at most ``most``."""
    if not looks:
        return
    dated = looks[0].history.dated
    told = _shown_of(len(looks), most, "parameter")
    table = ReportTable(
        f"\n{told[:1].upper()}{told[1:]} over time: healthy value, last value, change, and when it began"
    )
    table.words("parameter")
    table.numbers("healthy", "last", "change")
    table.words("since")
    table.numbers("per month" if dated else "per result", "to the limit", "reaches it in")
    for look in looks[:most]:
        of = look.history
        slope = None if look.trend is None else look.trend.slope * (_MONTH if dated else 1.0)
        table.add_row(
            escape(number_words(look)),
            quantity(look.healthy, of.unit),
            estimate(float(of.values[-1]), float(of.errors[-1]), of.unit),
            escape(change_of(look)),
            escape(of.names[look.change.begin]) if look.change else "",
            "no trend" if slope is None else quantity(slope, of.unit),
            "" if look.margin is None else f"{100.0 * look.margin.share:.0f} %",
            life_words(look),
        )
    console.print(table)

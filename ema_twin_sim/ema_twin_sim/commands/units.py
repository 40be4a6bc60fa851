"""``ema-twin units``: a campaign's results, one row per unit."""

from __future__ import annotations

from pathlib import Path
from shlex import quote
from typing import Annotated

import typer

from ..listing import by_recording, number_of
from . import options
from .output import counted, say, warn

EXAMPLES = """Examples:

ema-twin units results

ema-twin units results --json units.json

ema-twin units results --unit EMA-007     (its recordings, one by one, and how its numbers change)

ema-twin units results --page fleet     (then open fleet/index.html)

ema-twin units results --limits limits.yaml --healthy 10     (limits.yaml: backlash.width: 0.004)

ema-twin units results --unit EMA-007 --rrd history.rrd

ema-twin units results --unit rig --healthy "^normal"     (after campaign --do health: what its other tests are like)"""

_ROWS = 20
"""Rows of a table that are shown unless all are asked for."""


def run(
    results: Annotated[Path, typer.Argument(metavar="RESULTS", help="The folder that campaign wrote.")],
    unit: Annotated[str | None, typer.Option(metavar="NAME", help="Show each recording of this unit.")] = None,
    limits: Annotated[
        Path | None, typer.Option(metavar="FILE.yaml", help="Limits of numbers, in SI units: backlash.width: 0.004")
    ] = None,
    healthy: Annotated[
        str | None,
        typer.Option(
            metavar="N|PATTERN",
            help="Which results of each unit are healthy: the first N, or those whose name matches a regular "
            "expression; by default the first third.",
        ),
    ] = None,
    page: Annotated[
        Path | None, typer.Option(metavar="FOLDER", help="Also write pages: FOLDER/index.html, and one of each unit.")
    ] = None,
    whole: Annotated[
        bool, typer.Option("--all", help="Show all rows of the tables, however many; by default the most telling.")
    ] = False,
    rrd: Annotated[
        Path | None, typer.Option(metavar="FILE.rrd", help="Also write the history of --unit as views for rerun.")
    ] = None,
    force: options.Force = False,
    json: options.JsonFile = None,
) -> None:
    """Show which unit misses which effect, how far its recordings are off, and which of its numbers change.

    If a parameter has left the range of its healthy values, the recording where that began is shown; if it has a trend
    and a limit, also when it reaches the limit.
    """
    from ema_bench_replay.errors import InputError

    from ..campaign.copies import copies_across
    from ..campaign.feature_courses import feature_courses
    from ..campaign.healthy import Healthy
    from ..campaign.healthy_chosen import check_choice
    from ..campaign.histories import FEWEST_HEALTHY, Outlook, outlooks, read_limits
    from ..campaign.store import Store
    from ..campaign.unit_health import UnitHealth, sickest_first, unit_health
    from ..campaign.units import units_of
    from ..model.model import nearest
    from ..words.units import fleet_words, unit_words
    from .inputs import check_outputs, write_json
    from .shown_units import show_health, show_numbers, show_recordings, show_units

    if rrd is not None and unit is None:
        raise InputError(f"--rrd {rrd}: shows one unit; name it with --unit")
    overview = None if page is None else page / "index.html"
    check_outputs([] if limits is None else [limits], force, json=json, page=overview, rrd=rrd)
    of_numbers = read_limits(limits)
    known_good = Healthy.of(healthy, FEWEST_HEALTHY)
    found = units_of(Store.opened(results).rows())
    names = tuple(one.name for one in found)
    copies = copies_across(found, unit)
    if unit is not None:
        found = [one for one in found if one.name == unit]
        if not found:
            raise InputError(
                f"{results}: holds no unit '{unit}'; {nearest(unit, names)} (all: ema-twin units {quote(str(results))})"
            )
    short = [] if healthy is None else check_choice(found, known_good, healthy, FEWEST_HEALTHY)
    ahead: dict[str, list[Outlook]] = {}
    health: dict[str, UnitHealth | None] = {}
    with counted(len(found), "comparing with the healthy results") as done:
        for one in found:
            ahead[one.name] = outlooks(one, of_numbers, known_good)
            health[one.name] = unit_health(one, known_good)
            done(one.name)
    if rrd is not None and not any(ahead.values()) and not any(of is not None and of.judged for of in health.values()):
        raise InputError(f"--rrd {rrd}: too few results of {unit} have numbers, and no health of it was judged")
    found = sickest_first(found, health)
    followed = tuple(dict.fromkeys(look.history.path for looks in ahead.values() for look in looks))
    for path in (path for path in of_numbers if path not in followed):
        hint = f"; {nearest(path, followed)}" if followed else ""
        warn(f"{limits}: none of these units has a history of {path}{hint}")
    most = None if whole else _ROWS
    if unit is not None:
        say(f"{unit}: {' '.join(unit_words(found[0], ahead[unit], health[unit]))}")
        show_health(health[unit], feature_courses(found[0], health[unit]), most)
        show_numbers(ahead[unit], most)
        show_recordings(found[0], health[unit], most)
    else:
        say(f"{number_of(len(found), 'unit')}: {fleet_words(found, ahead, health)}")
        show_units(found, ahead, health, most)
    for one in found:
        if not all(look.history.as_asked for look in ahead[one.name]):
            warn(
                f"{one.name}: some of its parameters are compared with their first "
                f"{'third' if known_good.pattern else f'{FEWEST_HEALTHY} values or days'}, because --healthy {healthy} "
                f"selects fewer than {FEWEST_HEALTHY} of their values or days"
            )
    of_health = ((one.name, of) for one in found if (of := health[one.name]) is not None)
    remarks = [f"{one.name}: {remark}" for one in found for remark in one.remarks]
    remarks += [f"{name}: {remark}" for name, of in of_health for remark in of.remarks]
    for warning in [*copies, *by_recording([*short, *remarks])]:
        warn(warning)
    if rrd is not None and unit is not None:
        from ..views.unit_history import write_unit_history
        from .rerun_file import tell_of_rrd

        tell_of_rrd(rrd, write_unit_history(rrd, ahead[unit], health[unit], force=force))
    if page is not None:
        from ..report.fleet import write_fleet

        with counted(len(found), "writing pages") as done:
            overview = write_fleet(page, found, ahead, health, copies, force=force, done=done)
        say(f"{overview}: open it in any browser")
    numbers = {name: [look.as_json() for look in looks] for name, looks in ahead.items()}
    judged = {name: None if of is None else of.as_json() for name, of in health.items()}
    write_json(json, [{**one.as_json(), "numbers": numbers[one.name], "health": judged[one.name]} for one in found])

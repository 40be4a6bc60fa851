"""``ema-twin units``: a campaign's results, a row for every unit."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.markup import escape

from . import options
from .inputs import write_json
from .output import console, say, warn
from .tables import ReportTable
from .wording import effect_words

if TYPE_CHECKING:
    from ..campaign.units import Unit

EXAMPLES = """Examples:

ema-twin units results

ema-twin units results --json units.json

ema-twin units results --unit EMA-007     (its recordings, one by one)"""

_SHOWN = 3
"""Effects of a unit that are named in its row."""


def run(
    results: Annotated[Path, typer.Argument(metavar="RESULTS", help="The folder that campaign wrote.")],
    unit: Annotated[str | None, typer.Option("--unit", metavar="NAME", help="Only this unit, each recording.")] = None,
    json: options.JsonFile = None,
) -> None:
    """Show which unit misses which effect, how far its recordings are off, and what of them could not be judged."""
    from ema_bench_replay.errors import InputError

    from ..campaign.store import Store
    from ..campaign.units import units_of

    found = units_of(Store.opened(results).rows())
    if unit is not None:
        found = [one for one in found if one.name == unit]
        if not found:
            raise InputError(f"{results}: holds no unit '{unit}'; ema-twin units {results} lists them")
        _show_recordings(found[0])
    else:
        _show(found)
    for one in found:
        for remark in one.remarks:
            warn(f"{one.name}: {remark}")
    write_json(json, [one.as_json() for one in found])


def _show(units: list[Unit]) -> None:
    table = ReportTable(f"{len(units)} units, the ones with most beyond the sensors' noise first")
    table.words("unit")
    table.numbers("judged", "refused", "failed")
    table.words("last recorded", "missing in")
    table.numbers("beyond noise")
    for one in units:
        table.add_row(
            escape(one.name),
            str(one.judged),
            str(one.refused or ""),
            str(one.failed or ""),
            f"{one.last:%Y-%m-%d}" if one.last else "",
            _missing(one),
            "" if one.beyond_noise is None else f"{one.beyond_noise:.1f} ×",
        )
    console.print(table)
    say("Beyond noise: the largest error of a signal in its last recording, in times the sensors' noise.")


def _missing(one: Unit) -> str:
    if not one.searched:
        return ""
    told = [f"{effect_words(effect)} {count}/{one.searched}" for effect, count in one.missing[:_SHOWN]]
    more = len(one.missing) - _SHOWN
    return ", ".join([*told, *([f"{more} more"] if more > 0 else [])]) or "nothing"


def _show_recordings(one: Unit) -> None:
    table = ReportTable(f"{one.name}: {len(one.rows)} results")
    table.words("recording", "recorded", "task", "verdict", "missing")
    table.numbers("beyond noise")
    table.words("why not")
    for row in one.rows:
        beyond = one.beyond(row)
        table.add_row(
            escape(row["name"]),
            f"{row['time']:%Y-%m-%d %H:%M}" if row["time"] else "",
            row["task"],
            row["verdict"] or row["status"],
            ", ".join(effect_words(effect) for effect in row["missing"] or ()),
            "" if beyond is None else f"{beyond:.1f} ×",
            escape(row["message"] or ""),
        )
    console.print(table)

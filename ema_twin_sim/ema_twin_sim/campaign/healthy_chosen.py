"""Whether the choice of healthy results leaves something to compare: some that are healthy, and others."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

from ema_bench_replay.errors import InputError

from .healthy import Healthy
from .results import DONE
from .units import Row, Unit


def check_choice(units: Sequence[Unit], healthy: Healthy, asked: str, fewest: int) -> list[str]:
    """A warning for each unit of whose results all are healthy. ``asked`` is what the user wrote.

    Raises InputError if no unit has both healthy results and others.
    """
    chosen = {unit.name: _chosen(unit, healthy) for unit in units if unit.judged}
    if chosen and not any(0 < count < among for count, among, _ in chosen.values()):
        raise InputError(f"--healthy {asked}: {_reason(units, healthy, [*chosen.values()], fewest)}")
    return [
        f"{name}: all its {among} results are healthy by --healthy {asked}, so none is left to compare with them"
        for name, (count, among, _) in chosen.items()
        if count == among
    ]


def _chosen(unit: Unit, healthy: Healthy) -> tuple[int, int, int]:
    """(number of healthy results, of all, of those before the last test) of the task that has most others.

    The tasks are judged apart.
    """
    done = sorted((row for row in unit.rows if row["status"] == DONE), key=lambda row: str(row["task"]))
    counts = []
    for _, rows in groupby(done, key=lambda row: row["task"]):
        names, tests = zip(*((row["name"], _test(row)) for row in rows), strict=True)
        counts.append((sum(healthy.among(names, tests, 0)), len(names), tests.index(tests[-1])))
    return max(counts, key=lambda of: (0 < of[0] < of[1], of[1]))


def _test(row: Row) -> str:
    """The test that a result belongs to; its name if it has none."""
    return str(row["health"]["test"] if row["health"] else row["name"])


def _reason(units: Sequence[Unit], healthy: Healthy, chosen: Sequence[tuple[int, int, int]], fewest: int) -> str:
    """Why nothing can be compared, and what to do."""
    whose = f"{units[0].name} has" if len(units) == 1 else "no unit has more than"
    _, most, useful = max(chosen, key=lambda of: (of[2], of[1]))
    if healthy.pattern is None:
        fewer = f"give {fewest} to {useful}" if useful >= fewest else "give fewer"
        return (
            f"leaves nothing to compare, because {whose} {most} results; {fewer}, or a regular expression that the "
            "names of the healthy ones match"
        )
    if any(count for count, *_ in chosen):
        return "leaves nothing to compare, because all results have a name with that; correct the pattern"
    some = next(row["name"] for unit in units for row in unit.rows if row["status"] == DONE)
    of = f" of {units[0].name}" if len(units) == 1 else ""
    return f"no result{of} has a name with that, as '{some}' is one; correct the pattern"

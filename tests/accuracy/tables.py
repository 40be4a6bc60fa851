"""Verdicts summed up: totals, and which effect was taken for which."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from statistics import median
from typing import Any

from .judge import Verdict


def totals(verdicts: Sequence[Verdict]) -> dict[str, Any]:
    """Counts, medians and shares over all verdicts; None where nothing was there to be counted."""
    errors = [error for verdict in verdicts for error in verdict.errors.values()]
    within = [inside for verdict in verdicts for inside in verdict.within.values()]
    options = [verdict.options for verdict in verdicts if verdict.options is not None]
    removed = [verdict.removed for verdict in verdicts if verdict.removed == verdict.removed]
    nothing = [verdict for verdict in verdicts if not verdict.hidden]
    seconds = [verdict.seconds for verdict in verdicts]
    return {
        "cases": len(verdicts),
        "found": sum(verdict.found for verdict in verdicts),
        "first": sum(verdict.first for verdict in verdicts),
        "wrong": sum(bool(verdict.wrong) for verdict in verdicts),
        "nothing_hidden": len(nothing),
        "false_alarms": sum(bool(verdict.wrong) for verdict in nothing),
        "broken": sum(bool(verdict.error) for verdict in verdicts),
        "right_options": (sum(options), len(options)),
        "median_removed": median(removed) if removed else None,
        "parameters": len(errors),
        "median_parameter_error": _finite(median(errors)) if errors else None,
        "within_three_errors": sum(within) / len(within) if within else None,
        "median_seconds": median(seconds) if seconds else None,
        "worst_seconds": max(seconds, default=None),
    }


def totals_line(verdicts: Sequence[Verdict]) -> str:
    """The totals in one paragraph."""
    sums = totals(verdicts)
    count = sums["cases"]
    right, with_options = sums["right_options"]
    parts = [
        f"cases {count}",
        f"named exactly {sums['found']}/{count}",
        f"first right {sums['first']}/{count}",
        f"confidently wrong {sums['wrong']}/{count}",
        f"false alarms {sums['false_alarms']}/{sums['nothing_hidden']}",
        f"options right {right}/{with_options}",
        f"BROKEN {sums['broken']}\n" if sums["broken"] else "\n",
        f"median removed {_percent(sums['median_removed'])}",
        f"median parameter error {_percent(sums['median_parameter_error'], 2)} of {sums['parameters']}",
        f"truth within three standard errors {_percent(sums['within_three_errors'], 0)}",
        f"seconds a case: median {sums['median_seconds'] or 0.0:.1f}, worst {sums['worst_seconds'] or 0.0:.1f}",
    ]
    return "  ".join(parts).replace("\n  ", "\n")


def by_kind(verdicts: Sequence[Verdict]) -> str:
    """Named exactly and confidently wrong, a line a kind."""
    lines = [f"{'kind':24s} {'named':>8s} {'wrong':>6s} {'seconds':>8s}"]
    for kind in dict.fromkeys(verdict.kind for verdict in verdicts):
        group = [verdict for verdict in verdicts if verdict.kind == kind]
        sums = totals(group)
        lines.append(f"{kind:24s} {sums['found']:4d}/{len(group):<3d} {sums['wrong']:6d} {sums['median_seconds']:8.1f}")
    return "\n".join(lines)


def confusion(verdicts: Sequence[Verdict]) -> dict[str, Counter[str]]:
    """Hidden effect: what was named where it was hidden, and how often; ``-`` where it was itself not named.

    What is rightly named beside it (another hidden effect) does not count; ``nothing`` is the row of empty cases.
    """
    table: dict[str, Counter[str]] = {}
    for verdict in verdicts:
        for id in verdict.hidden or ("nothing",):
            row = table.setdefault(id, Counter())
            others = [name for name in verdict.added if name not in verdict.hidden]
            right = id in verdict.added or (id == "unknown" and verdict.verdict == "unknown")
            row.update([id] if right else ["-"])
            row.update(others)
    return table


def confusion_table(verdicts: Sequence[Verdict]) -> str:
    """The confusion table: hidden, how often, how often named, and what else was named where it was hidden."""
    lines = [f"{'hidden':24s} {'times':>5s} {'named':>5s}  also or instead"]
    for id, row in sorted(confusion(verdicts).items()):
        times = row[id] + row["-"]
        others = ", ".join(f"{name} x{count}" for name, count in row.most_common() if name not in (id, "-"))
        named = f"{row[id]:5d}" if id != "nothing" else "    -"
        lines.append(f"{id:24s} {times:5d} {named}  {others}")
    return "\n".join(lines)


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _percent(share: float | None, decimals: int = 1) -> str:
    return "-" if share is None else f"{100.0 * share:.{decimals}f} %"

"""Calibration: whether what is said with some probability is true as often, and whether intervals cover the truth."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ema_twin_sim.discovery.diagnose import weigh
from ema_twin_sim.discovery.discover import discover

from .cases import Case, drawn_cases
from .experiments import left_out_cases, null_cases
from .folders import readable_train
from .judge import deviations
from .other_machines import other_machine_cases

EDGES = (0.0, 0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 0.97, 1.0)
"""Edges of the reliability table's bins."""
NINETY = 1.645
"""Standard errors to both sides of an interval that holds nine of ten."""


@dataclass(frozen=True)
class Statement:
    """Something said with a probability, and whether it was so."""

    case: str
    what: str  # an effect's id, none or unknown
    probability: float
    true: bool


@dataclass(frozen=True)
class Judged:
    """What the diagnosis of one case said: its statements, and whether 90 % intervals held the truth."""

    case: str
    statements: tuple[Statement, ...]
    covered: Mapping[str, bool]
    error: str = ""

    def line(self) -> str:
        """The surest statements in a line."""
        said = sorted(self.statements, key=lambda s: -s.probability)[:4]
        words = (f"{s.what} {s.probability:.0%}{'' if s.true else ' (not so)'}" for s in said)
        return f"{self.case:24s} {self.error or ', '.join(words)}"


def calibration_cases(seed: int, count: int) -> tuple[list[Case], list[tuple[str, ...]]]:
    """Cases of all kinds in equal parts but for fewer empty ones, and the effects that each may not name."""
    many, few = -(-count * 3 // 10), -(-count // 10)
    left_out = left_out_cases(seed, few)
    others = [*drawn_cases(seed, count - many - 2 * few), *other_machine_cases(seed, many)]
    cases = [*others, *left_out, *null_cases(seed, few)]
    return cases, [(case.kind,) if case in left_out else () for case in cases]


def weighed(case: Case, without: Sequence[str] = ()) -> Judged:
    """The diagnosis of one case, judged."""
    try:
        found = discover(readable_train(case), case.start_model, without=tuple(without))
        diagnosis = weigh(found).as_json()
        return judged(case, diagnosis, found.as_json(), without)
    except Exception as error:  # whatever it is, the case is lost and the others go on
        return Judged(case.name, (), {}, f"{type(error).__name__}: {error}"[:300])


def judged(
    case: Case, diagnosis: Mapping[str, Any], discovery: Mapping[str, Any], without: Sequence[str] = ()
) -> Judged:
    """The statements of a diagnosis and the intervals of a discovery, held against what is hidden.

    Not judged are effects that the bench has besides.
    """
    hidden = {"unknown" if id in without else id for id in case.hidden}
    said = {}
    for entry in diagnosis["ranking"]:
        said[entry["effect"]] = max(entry["probability"], said.get(entry["effect"], 0.0))
    statements = [
        Statement(case.name, id, probability, id in hidden)
        for id, probability in said.items()
        if id not in case.tolerated
    ]
    if not case.restless:
        statements.append(Statement(case.name, "none", diagnosis["none"], not hidden))
        statements.append(Statement(case.name, "unknown", diagnosis["unknown"], "unknown" in hidden))
    covered = {
        f"{id}.{name}": abs(off) <= NINETY * sum(spreads)
        for (id, name), off, spreads in deviations(case, discovery)
        if spreads and None not in spreads
    }
    return Judged(case.name, tuple(statements), covered)


def reliability(statements: Sequence[Statement]) -> list[dict[str, float]]:
    """Per bin of EDGES: how many statements, with what mean probability, and what share of them was true."""
    rows = []
    for low, high in itertools.pairwise(EDGES):
        inside = [s for s in statements if low <= s.probability < high or (high == 1.0 and s.probability == 1.0)]
        if inside:
            said = sum(s.probability for s in inside) / len(inside)
            true = sum(s.true for s in inside) / len(inside)
            rows.append({"low": low, "high": high, "count": len(inside), "said": said, "true": true})
    return rows


def calibration_error(rows: Sequence[Mapping[str, float]]) -> float:
    """Expected calibration error: the mean distance of said and true shares, each bin as often as it was used."""
    count = sum(row["count"] for row in rows)
    return sum(row["count"] * abs(row["said"] - row["true"]) for row in rows) / max(count, 1)


def brier(statements: Sequence[Statement]) -> float:
    """Brier's score: the mean squared distance of a probability from what was so."""
    return sum((s.probability - s.true) ** 2 for s in statements) / max(len(statements), 1)


def summed_up(found: Sequence[Judged]) -> dict[str, Any]:
    """The reliability table with and without what is next to impossible, scores, and the intervals' coverage."""
    statements = [s for each in found for s in each.statements]
    telling = [s for s in statements if s.probability >= EDGES[1]]
    covered = [held for each in found for held in each.covered.values()]
    return {
        "cases": len(found),
        "broken": [f"{each.case}: {each.error}" for each in found if each.error],
        "reliability": reliability(statements),
        "brier": brier(statements),
        "calibration_error": calibration_error(reliability(statements)),
        "calibration_error_telling": calibration_error(reliability(telling)),
        "statements": len(statements),
        "telling": len(telling),
        "intervals": len(covered),
        "covered": sum(covered) / len(covered) if covered else None,
        "off": [[s.case, s.what, s.probability, s.true] for s in telling if abs(s.probability - s.true) > 0.5],
    }


def table(sums: Mapping[str, Any]) -> str:
    """The reliability table and the scores, to be printed."""
    lines = [f"{'said':>15s} {'statements':>10s} {'mean':>7s} {'true':>7s}"]
    for row in sums["reliability"]:
        lines.append(f"{row['low']:7.0%}-{row['high']:<7.0%} {row['count']:10d} {row['said']:7.1%} {row['true']:7.1%}")
    covered = "-" if sums["covered"] is None else f"{sums['covered']:.1%}"
    lines += [
        f"{sums['cases']} cases, {sums['statements']} statements, {len(sums['broken'])} cases broken",
        f"Brier score {sums['brier']:.4f}",
        f"expected calibration error {sums['calibration_error']:.4f}, of the {sums['telling']} statements of 2 % and "
        f"more {sums['calibration_error_telling']:.4f}",
        f"90 % intervals that hold the truth: {covered} of {sums['intervals']}",
        *(f"off: {case} {what} said {said:.0%}, was {true}" for case, what, said, true in sums["off"]),
    ]
    return "\n".join([*lines, *sums["broken"]])

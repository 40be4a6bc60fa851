"""``make accuracy``: effects hidden in another bench, given to discovery, and how well it named them.

python -m tests.accuracy.run [--seed 1] [--cases 60] [--kinds plain pairs ...] [--only NAME ...]
python -m tests.accuracy.run --known                        (what was once missed; ends with 1 if one is lost again)
python -m tests.accuracy.run --null 40 | --laws 40 | --leave-out | --sweep [EFFECT ...] | --robust
python -m tests.accuracy.run --limits [EFFECT ...] [--cases 10]              (benches an effect)
python -m tests.accuracy.run --other-machines 60 | --alone 60 | --calibration | --contradictions 200
python -m tests.accuracy.run --strangers 40 | --textbook 28 | --mistakes 20  [--plain] [--single] [--keep DIR]
python -m tests.accuracy.run --save DIR        (cases as folders, for other scorers; discovery is not run)
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from . import experiments
from .calibration import Judged, calibration_cases, summed_up, table, weighed
from .cases import KINDS, Case, drawn_cases
from .contradictions import Checked, checked
from .folders import save
from .judge import Verdict
from .known import REASONS, kept, known_cases
from .limits import BENCHES, ENOUGH, LIMITED, limit_table, limits
from .other_machines import other_machine_cases
from .planned import Pair, planned_and_not, planned_cases
from .strangers.cases import Stranger, mistaken_cases, stranger_cases
from .strangers.run import run_strangers
from .strangers.textbook import Textbook, textbook_cases
from .tables import by_kind, confusion, confusion_table, totals, totals_line
from .work import WORKERS, Solvers

Named = TypeVar("Named", Case, Stranger, Textbook)
Answer = TypeVar("Answer", Verdict, Judged, Checked, Pair)
_SETS: Mapping[str, Callable[[int, int], list[Case]]] = {
    "null": experiments.null_cases,
    "other_machines": other_machine_cases,
    "alone": experiments.alone_cases,
    "laws": experiments.law_cases,
}
"""The sets of cases that are drawn from a seed and a number, by their options."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run what was asked for; the exit status is 0 whatever the score is, and 1 where a known case is lost."""
    asked = _parser().parse_args(arguments)
    start = time.perf_counter()
    if asked.save:
        for case in _default_cases(asked):
            print(save(case, asked.save))
        return 0
    if asked.strangers or asked.mistakes or asked.textbook:
        told = run_strangers(_strangers(asked), asked.workers, asked.keep)
        report = {"seed": asked.seed, **told}
    else:
        with Solvers(asked.workers) as solve:
            report = {"seed": asked.seed, **_asked_for(asked, solve)}
    print(f"{time.perf_counter() - start:.0f} s in all, {asked.workers} at a time")
    if asked.json:
        asked.json.write_text(json.dumps(report, indent=1), "utf-8")
    return 1 if report.get("lost") else 0


def _asked_for(asked: argparse.Namespace, solve: Solvers) -> dict[str, Any]:
    """What the chosen experiment found, for the JSON; it is printed on the way."""
    say = partial(print, flush=True)
    if asked.sweep is not None:
        say(f"smallest size named in {experiments.ENOUGH} of {experiments.TRIES} cases")
        return {"limits": experiments.sweep(asked.seed, asked.sweep or experiments.SWEPT, solve, say)}
    if asked.limits is not None:
        benches = asked.cases or BENCHES
        say(f"smallest multiple of the limit that is named on {ENOUGH:.0%} of {benches} benches")
        found = limits(asked.seed, asked.limits or LIMITED, benches, solve, say)
        print("", limit_table(found, benches), sep="\n")
        return {"limits": found}
    if asked.leave_out:
        cases = _only(asked, experiments.left_out_cases(asked.seed, asked.cases or len(experiments.SWEPT)))
        return _left_out(_solved(solve, cases, [case.kind for case in cases]))
    if asked.calibration:
        cases, excluded = calibration_cases(asked.seed, asked.cases or 300)
        judged = _shown(solve.each(weighed, cases, excluded), len(cases))
        sums = summed_up(judged)
        print("", table(sums), sep="\n")
        return {"calibration": sums, "cases": [asdict(one) for one in judged]}
    if asked.contradictions:
        return _contradictions(asked.seed, asked.contradictions, solve)
    if asked.planned:
        return _planned(asked.seed, asked.planned, solve)
    if asked.known:
        return _known(_solved(solve, _only(asked, known_cases())))
    return _report(_solved(solve, _cases(asked)))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        "accuracy", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add, add_count = parser.add_argument, partial(parser.add_argument, type=_count, metavar="N")
    add("--seed", type=int, default=1)
    add(
        "--cases",
        type=_count,
        help="60 by default; with --calibration 300; with --robust, per condition (12); with --limits, benches (10)",
    )
    add("--kinds", nargs="+", choices=KINDS, default=KINDS)
    add("--only", nargs="+", default=(), metavar="NAME", help="of the drawn cases, these")
    add("--known", action="store_true", help="the cases that were once missed: all are to be named")
    add_count("--null", help="N benches with nothing hidden")
    add_count("--other-machines", help="N benches of other sizes, none of them kind")
    add_count("--alone", help="N cases of one recording each, some of them short")
    add_count("--laws", help="N benches whose friction follows one of several laws")
    add("--leave-out", action="store_true", help="the hidden effect is taken out of the catalogue")
    add("--sweep", nargs="*", choices=experiments.SWEPT, metavar="EFFECT", help="detection limits")
    add("--limits", nargs="*", choices=LIMITED, metavar="EFFECT", help="detection limits on unkind benches")
    add("--calibration", action="store_true", help="whether probabilities and intervals are right")
    add_count("--planned", help="N cases by one slow recording and two that plan asks for")
    add_count("--strangers", help="N servos in their owners' words and units")
    add_count("--textbook", help="N machines by a textbook's law of friction")
    add_count("--mistakes", help="N of them with a wrong unit or sign")
    add("--plain", action="store_true", help="of --strangers, in the tutorial's names and SI units")
    add("--single", action="store_true", help="of --strangers, one recording each instead of three")
    add("--keep", type=Path, metavar="DIR", help="of these three: where their files stay")
    add_count("--contradictions", help="N cases of both benches: is all of it told alike")
    add("--robust", action="store_true", help="the same cases under unkind conditions")
    add("--workers", type=_count, default=WORKERS)
    add("--json", type=Path, metavar="FILE")
    add("--save", type=Path, metavar="DIR")
    return parser


def _count(text: str) -> int:
    """A number of things, from one on."""
    if not text.isdigit() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"'{text}' is no count; give a whole number from 1 on")
    return int(text)


def _cases(asked: argparse.Namespace) -> list[Case]:
    """The cases of the set that was asked for, by default of all kinds."""
    for name, drawn in _SETS.items():
        if count := getattr(asked, name):
            return _only(asked, drawn(asked.seed, count))
    if asked.robust:
        return _only(asked, experiments.robustness_cases(asked.seed, asked.cases or 12))
    return _default_cases(asked)


def _default_cases(asked: argparse.Namespace) -> list[Case]:
    return _only(asked, drawn_cases(asked.seed, asked.cases or 60, asked.kinds))


def _strangers(asked: argparse.Namespace) -> list[Stranger] | list[Textbook]:
    if asked.textbook:
        return _only(asked, textbook_cases(asked.seed, asked.textbook))
    if asked.mistakes:
        return _only(asked, mistaken_cases(asked.seed, asked.mistakes))
    return _only(asked, stranger_cases(asked.seed, asked.strangers, plain=asked.plain, alone=asked.single))


def _only(asked: argparse.Namespace, cases: Sequence[Named]) -> list[Named]:
    """Of the drawn cases, those that ``--only`` names."""
    unknown = set(asked.only) - {case.name for case in cases}
    if unknown:
        sys.exit(f"--only: no case {', '.join(sorted(unknown))}; there are {cases[0].name} to {cases[-1].name}")
    return [case for case in cases if not asked.only or case.name in asked.only]


def _shown(answers: Iterable[Answer], total: int) -> list[Answer]:
    """The answers, each printed as it comes."""
    found = []
    for number, answer in enumerate(answers, 1):
        print(f"{number:4d}/{total} {answer.line()}", flush=True)
        found.append(answer)
    return found


def _solved(solve: Solvers, cases: Sequence[Case], without: Sequence[str] = ()) -> list[Verdict]:
    """The verdicts, shown as they come; returned in the order of the cases."""
    by_name = {verdict.case: verdict for verdict in _shown(solve(cases, without), len(cases))}
    return [by_name[case.name] for case in cases]


def _report(verdicts: list[Verdict]) -> dict[str, Any]:
    print("", confusion_table(verdicts), "", by_kind(verdicts), "", totals_line(verdicts), sep="\n")
    return {
        "totals": totals(verdicts),
        "confusion": {id: dict(row) for id, row in confusion(verdicts).items()},
        "cases": [verdict.as_json() for verdict in verdicts],
    }


def _known(verdicts: list[Verdict]) -> dict[str, Any]:
    """Which of the known cases are lost again, and what had once gone wrong with them."""
    lost = {verdict.case: REASONS[verdict.case] for verdict in verdicts if not kept(verdict)}
    print("", f"known cases named, and nothing wrong beside: {len(verdicts) - len(lost)} of {len(verdicts)}", sep="\n")
    for name, reason in lost.items():
        print(f"LOST {name}: {reason}")
    return {"lost": lost, "cases": [verdict.as_json() for verdict in verdicts]}


def _left_out(verdicts: list[Verdict]) -> dict[str, Any]:
    """Without the true effect in the catalogue, naming anything is false, but for what else was hidden."""
    said = {verdict: sum(v.verdict == verdict for v in verdicts) for verdict in ("unknown", "none", "explained")}
    said["wrong"] = sum(bool(v.wrong) for v in verdicts)
    print("", f"true effect left out: {len(verdicts)} cases, unknown {said['unknown']}, none {said['none']}", sep="\n")
    rest = [v for v in verdicts if v.verdict == "explained" and not v.wrong]
    print(f"explained by what else was hidden {len(rest)}: {', '.join(v.case for v in rest)}")
    wrong = (f"{v.kind} as {'+'.join(v.wrong)}" for v in verdicts if v.wrong)
    print(f"wrong names in {said['wrong']} ({said['wrong'] / max(len(verdicts), 1):.1%}): {', '.join(wrong)}")
    return {"left_out": said, "cases": [verdict.as_json() for verdict in verdicts]}


def _contradictions(seed: int, count: int, solve: Solvers) -> dict[str, Any]:
    """Whether all that is said of a case is told alike: three of four cases of the first bench, then the other's."""
    kind, unkind = -(-3 * count // 4), count // 4
    cases = [*drawn_cases(seed, kind), *(other_machine_cases(seed, unkind) if unkind else ())]
    found = _shown(solve.each(checked, cases), len(cases))
    print(f"{sum(len(one.contradictions) for one in found)} contradictions in {len(cases)} cases")
    return {"contradictions": [one._asdict() for one in found]}


def _planned(seed: int, count: int, solve: Solvers) -> dict[str, Any]:
    """One slow recording and two that plan asks for, beside two that nobody planned."""
    pairs = _shown(solve.each(planned_and_not, planned_cases(seed, count)), count)
    right = {how: sum(getattr(pair, how).found for pair in pairs) for how in ("planned", "unplanned")}
    wrong = {how: sum(bool(getattr(pair, how).wrong) for pair in pairs) for how in right}
    for how in right:
        print(f"{how}: {right[how]} of {count} right, {wrong[how]} confidently wrong")
    return {"right": right, "wrong": wrong, "cases": [asdict(pair) for pair in pairs]}


if __name__ == "__main__":
    sys.exit(main())

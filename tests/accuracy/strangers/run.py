"""Strangers' servos given to ``init`` and ``discover``, several at a time, and what came of them in numbers."""

from __future__ import annotations

import statistics
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from pathlib import Path
from typing import Any

from .cases import Stranger
from .judge import Answer, answered
from .textbook import Textbook


def run_strangers(cases: Sequence[Stranger | Textbook], workers: int, keep: Path | None = None) -> dict[str, Any]:
    """Answer the cases, a line each, and sum up; ``keep`` is a folder for their files."""
    folders = [None if keep is None else keep / case.name for case in cases]
    answers = []
    with ThreadPoolExecutor(workers) as pool:
        for answer in pool.map(lambda case, folder: answered(case, folder=folder), cases, folders):
            print(answer.line(), flush=True)
            answers.append(answer)
    print("", *_summed_up(answers), sep="\n")
    return {"cases": [asdict(answer) for answer in answers]}


def _summed_up(answers: Sequence[Answer]) -> list[str]:
    """Lines: how many are right, how long they took, and how far constants are off."""
    refused = sum(answer.verdict == "refused" for answer in answers)
    seconds = [answer.seconds for answer in answers]
    lines = [
        f"right {sum(a.right for a in answers)} of {len(answers)}, refused {refused}, confidently wrong "
        f"{sum(a.wrong for a in answers)}; {statistics.median(seconds):.1f} s in the median, "
        f"{max(seconds):.1f} s at most"
    ]
    for name in dict.fromkeys(name for answer in answers for name in answer.off):
        off = [answer.off[name] for answer in answers if name in answer.off]
        within = sum(abs(error) <= 2.0 for error in off) / len(off)
        mean = statistics.mean(off)
        lines.append(f"{name}: {within:.0%} of {len(off)} within two standard errors, {mean:+.2f} of them in the mean")
    return lines

"""``python -m tests.accuracy.strangers``: strangers' servos, by ``init`` and ``discover`` with nothing edited.

python -m tests.accuracy.strangers [--count 40] [--seed 1] [--plain | --mistakes] [--only NAME ...] [--keep FOLDER]
"""

from __future__ import annotations

import argparse
import statistics
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from .cases import mistaken_cases, stranger_cases
from .judge import answered


def main() -> int:
    """Run what was asked for; the exit status is 0 when it ran, whatever the score."""
    parser = argparse.ArgumentParser("strangers", description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--plain", action="store_true", help="told in the tutorial's names, in SI units")
    parser.add_argument("--mistakes", action="store_true", help="with a wrong unit or sign, and nothing hidden")
    parser.add_argument("--only", nargs="+", default=(), metavar="NAME")
    parser.add_argument("--keep", type=Path, metavar="FOLDER")
    parser.add_argument("--workers", type=int, default=2)
    asked = parser.parse_args()
    cases = (
        mistaken_cases(asked.seed, asked.count)
        if asked.mistakes
        else stranger_cases(asked.seed, asked.count, plain=asked.plain)
    )
    cases = [case for case in cases if not asked.only or case.name in asked.only]
    answers = []
    with ThreadPoolExecutor(asked.workers) as pool:
        kept = [None if asked.keep is None else asked.keep / case.name for case in cases]
        for answer in pool.map(lambda case, folder: answered(case, folder=folder), cases, kept):
            print(answer.line(), flush=True)
            answers.append(answer)
    for name in dict.fromkeys(name for answer in answers for name in answer.off):
        off = [answer.off[name] for answer in answers if name in answer.off]
        within = sum(abs(error) <= 2.0 for error in off) / len(off)
        print(f"{name}: {within:.0%} of {len(off)} within two standard errors, {statistics.mean(off):+.2f} in the mean")
    refused = sum(a.verdict == "refused" for a in answers)
    seconds = [a.seconds for a in answers]
    print(
        f"right {sum(a.right for a in answers)} of {len(answers)}, refused {refused}, confidently wrong "
        f"{sum(a.wrong for a in answers)}; {statistics.median(seconds):.1f} s in the median, "
        f"{max(seconds):.1f} s at most"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())

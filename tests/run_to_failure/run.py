"""``make wear``: a fleet that runs to failure, judged by `health/` through the campaign's histories.

python -m tests.run_to_failure.run [--units 400] [--seed 1] [--workers 2]
python -m tests.run_to_failure.run --simulated 20     (recordings of virtual benches that wear, through `campaign`)
"""

from __future__ import annotations

import argparse
import multiprocessing
import tempfile
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np

from .judged import ASKED_AT, EARLY, Told, judged
from .simulated import judge_units, simulate_units, table


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--units", type=int, default=400)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--simulated", type=int, metavar="UNITS", help="simulate so many units, some 20 s each")
    asked = parser.parse_args(arguments)
    if asked.simulated is not None:
        with tempfile.TemporaryDirectory() as folder:
            simulate_units(Path(folder), asked.simulated, asked.seed)
            print(table(judge_units(Path(folder), asked.workers)))
        return 0
    with ProcessPoolExecutor(asked.workers, multiprocessing.get_context("spawn")) as pool:
        told = list(pool.map(partial(judged, seed=asked.seed), range(asked.units), chunksize=5))
    print(figures(told))
    return 0


def figures(told: Sequence[Told]) -> str:
    """The figures of a fleet, a line each."""
    worn = [one for one in told if one.wears is not None]
    early = [one.lost_when_named <= EARLY for one in worn]
    recordings, alarms = sum(one.recordings for one in told), sum(one.false_alarm for one in told)
    held = [answer for one in told for answer in one.held]
    known = [answer for answer in held if answer is not None]
    lines = [
        f"{len(told)} units, {len(worn)} of which wear",
        f"wear named before {100 * EARLY:.0f} % of the margin is lost: {np.mean(early):.1%} of {len(worn)}; "
        f"median loss then {np.median([one.lost_when_named for one in worn]):.1%}",
        f"named first what wears: {np.mean([one.first_named == one.wears for one in worn]):.1%}",
        f"false alarms: {alarms} in {recordings} recordings, {1000.0 * alarms / max(recordings, 1):.2f} per 1,000",
        f"90 % intervals of the remaining life hold it: {np.mean(known):.1%} of {len(known)}; "
        f"no trend was told in {len(held) - len(known)}",
        f"their width, median: {np.median([width for one in told for width in one.widths]):.2f} of the life",
    ]
    for k, share in enumerate(ASKED_AT):
        answers = [one.held[k] for one in worn if len(one.held) > k and one.held[k] is not None]
        lines.append(f"  with {100 * share:.0f} % of the margin lost: {np.mean(answers):.1%} of {len(answers)}")
    for kind in ("power", "exponential"):
        answers = [a for one in worn if one.law.startswith(kind) for a in one.held if a is not None]
        lines.append(f"  of {kind} laws: {np.mean(answers):.1%}")
    return "\n".join(lines)


if __name__ == "__main__":
    raise SystemExit(main())

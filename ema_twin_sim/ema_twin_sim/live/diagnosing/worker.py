"""The process that diagnoses for a monitor, one job after another.

Jobs come on standard input, answers go to standard output (see `frames`). It runs at a lower priority than the nodes,
and ends when they do.
"""

from __future__ import annotations

import os
import select
import sys
import threading

from .frames import receive_job, send

_NICENESS = 3


def main() -> int:
    """Serve until standard input ends; returns the exit status."""
    os.nice(_NICENESS)
    from .judge import judge  # after the priority is lowered: loading its libraries takes seconds

    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a library prints must not get into the answers
    threading.Thread(target=_end_with_the_nodes, daemon=True).start()
    while (job := receive_job(sys.stdin.buffer)) is not None:
        send(answers, judge(job))
    return 0


def _end_with_the_nodes() -> None:
    """End at once, even during a job, when the other end of standard input is closed."""
    waiting = select.poll()
    waiting.register(0, 0)  # wake up only for a hang-up
    waiting.poll()
    os._exit(0)

"""A bench goes on without readers that were killed, and these, started again, say truly what they did not see."""

import re
import time

import pytest

from tests.bench_processes import HISTORY, READERS, BenchProcesses

pytestmark = pytest.mark.slow

RATE = 1000.0
"""Hz."""
FEW = HISTORY // 2
"""Samples that a reader may lose as it joins: until its first answer the publisher does not wait for it, so that the
oldest that are kept are dropped while they are sent to it; on a busy machine that takes up to a second. A reader that
takes what it never saw for lost tells of all that came before it, three times as many and more."""


@pytest.fixture
def bench(tmp_path):
    bench = BenchProcesses(RATE, tmp_path)
    yield bench
    bench.close()


def test_the_bench_waits_for_no_reader_that_was_killed(bench):
    bench.kill(*READERS)
    bench.graph.spin_for(HISTORY / RATE + 3.0)
    assert bench.figures["replay"]["sent again, a reader was behind"] == "0"
    restarted = time.monotonic()
    for name in READERS:
        bench.start(name)
    bench.wait_for(*READERS)
    bench.graph.spin_for(2.0)  # all have told how they are
    told = "\n".join(bench.told_since(restarted))
    across = [
        int(number) for number in re.findall(r"twin: (\d+) samples of this run were lost; the twin integrated", told)
    ]
    assert max(across, default=0) < FEW, told
    assert "more than one node" not in told

"""A twin measures what its computing takes, and says where that is more than real time."""

import pytest

from ema_bench_replay.nodes import diagnostics
from ema_twin_sim.live.pace import Pace
from ema_twin_sim.live.sample_stream import SampleStream

MS = 1_000_000


class Clock:
    def __init__(self):
        self.now = 0

    def __call__(self):
        return self.now

    def takes(self, nanoseconds):
        def compute():
            self.now += nanoseconds
            return "answer"

        return compute


def test_the_present_pace_is_that_of_the_last_second_simulated():
    clock = Clock()
    pace = Pace(clock)
    assert pace.now is None and pace.overall is None and pace.complaint == ""
    for _ in range(1000):
        assert pace.timed(2 * MS, clock.takes(MS)) == "answer"
    assert pace.now == pytest.approx(2.0) and pace.complaint == ""
    for _ in range(500):
        pace.timed(2 * MS, clock.takes(5 * MS))
    assert pace.now == pytest.approx(0.4)
    assert pace.overall == pytest.approx(3000 / 3500)
    assert "needs 2.5 s per second of bench time" in pace.complaint and "drive.kind averaged" in pace.complaint


def test_one_step_longer_than_the_window_counts():
    clock = Clock()
    pace = Pace(clock)
    pace.timed(3000 * MS, clock.takes(6000 * MS))
    assert pace.now == pytest.approx(0.5)


def test_the_twins_diagnostics_warn():
    from ema_bench_replay.nodes.incoming import Incoming
    from ema_twin_sim.nodes.beside_bench import BesideBench

    class Follower:
        problem, input, answered = "", "setpoint", 10
        pace = Pace(Clock())

        stream = SampleStream()

    beside = BesideBench.__new__(BesideBench)
    beside.follower = Follower()
    beside.failure = None
    beside.incoming = Incoming("bench/state")
    beside.follower.stream.accept(1, 0, MS)
    assert beside.report().level == diagnostics.OK
    clock = Clock()
    Follower.pace = Pace(clock)
    Follower.pace.timed(MS, clock.takes(2 * MS))
    report = beside.report()
    assert report.level == diagnostics.WARN and "cannot run this model in real time" in report.message
    assert report.values["computes at"] == "0.5 × real time"

"""What the monitor says of a twin or a bench that falls silent, and of a window at another rate than the model's."""

import numpy as np
import pytest

from ema_bench_replay.nodes import qos
from ema_bench_replay.nodes.sample_codec import write_state
from ema_twin_msgs.msg import EmaState
from ema_twin_sim.live.verdict import Level, level_of
from ema_twin_sim.nodes.monitor import MonitorNode

SIGNALS = {"current": 0.1, "speed": 1.0, "motor_position": 2.0, "output_position": 0.5, "output_command": 0.5}


class Streams:
    """A monitor, and both streams that it compares."""

    def __init__(self, graph, **parameters):
        self.graph = graph
        self.monitor = graph.add(MonitorNode, services=False, **parameters)
        node = graph.plain_node()
        self.publishers = [node.create_publisher(EmaState, f"{side}/state", qos.STATE) for side in ("bench", "twin")]
        self.sent = self.answered = 0  # of one run
        self.skipped = 0  # samples of it that were sent before the monitor came
        self.graph.spin_until(lambda: all(p.get_subscription_count() for p in self.publishers))

    def send(self, samples, period=2_000_000, twin=True, residual=0.0):
        for _ in range(samples):
            self.sent += 1
            for k, publisher in enumerate(self.publishers[: 2 if twin else 1]):
                signals = {**SIGNALS, "current": 0.1 - k * residual}
                publisher.publish(write_state(self.sent * period, 1, self.sent - 1, signals))
            if self.sent % 50 == 0:
                self.graph.spin_for(0.005)
            self.answered += twin
        pairing = self.monitor.pairing
        self.graph.spin_until(
            lambda: pairing.bench.received == self.sent - self.skipped and pairing.compared == self.answered
        )

    @property
    def told(self):
        report = self.monitor._report()
        return Level(report.level[0]), report.message


@pytest.fixture
def streams(request, graph):
    return Streams(graph, **getattr(request, "param", {}))


SOON = pytest.mark.parametrize("streams", [{"stale_after": 5.0}], indirect=True)
"""Silence that is told of within a test, and that a busy machine does not make by itself."""


@pytest.mark.slow
@SOON
def test_a_twin_that_never_answers_or_ceases_to_is_no_good_health(streams):
    mute = "the twin does not answer the bench's samples"
    assert streams.told == (Level.STALE, "no samples received")
    streams.send(200, twin=False)
    assert streams.told == (Level.STALE, mute)
    assert not streams.monitor.complete

    def ceased():
        streams.send(1, twin=False)
        level, words = streams.told
        return level is Level.STALE and words.startswith(mute)  # what it missed before is told behind that

    streams.send(200)
    assert streams.told[0] is not Level.STALE
    streams.graph.spin_until(ceased)


@pytest.mark.slow
@SOON
def test_a_live_bench_that_stops_is_stale(streams):
    streams.send(200)
    assert streams.told[0] is Level.OK and streams.monitor.complete
    streams.graph.spin_until(lambda: streams.told == (Level.STALE, "no samples received"))


@pytest.mark.parametrize("streams", [{"window": 0.5}], indirect=True)
@pytest.mark.parametrize("period", [1_000_000, 2_000_000, 4_000_000])
def test_the_window_is_in_seconds_whatever_the_bench_sends(streams, period):
    streams.send(1000, period, residual=0.1)
    assert streams.monitor.comparison.rmse_window["current"] == pytest.approx(0.1)
    streams.send(round(0.25e9 / period), period)
    assert streams.monitor.comparison.rmse_window["current"] == pytest.approx(0.1 * np.sqrt(0.5), rel=0.01)
    streams.send(round(0.26e9 / period), period)
    assert streams.monitor.comparison.rmse_window["current"] == pytest.approx(0.0, abs=1e-12)


def test_levels():
    floor = {"current": 1.0, "speed": 1.0}
    none = dict.fromkeys(floor, float("nan"))
    assert level_of(none, floor, (), 3.0, 10.0)[0] is Level.STALE
    assert level_of({"current": 0.0, "speed": float("nan")}, floor, (), 3.0, 10.0)[0] is Level.OK
    assert level_of({"current": 20.0, "speed": 4.0}, floor, (), 3.0, 10.0)[0] is Level.ERROR
    assert level_of({"current": 20.0, "speed": 4.0}, floor, ("current",), 3.0, 10.0)[0] is Level.WARN


def test_two_benches_that_mix_are_told_though_the_twin_answers_neither(graph, streams):
    benches = streams.publishers[0], graph.nodes[-1].create_publisher(EmaState, "bench/state", qos.STATE)
    graph.spin_until(lambda: streams.monitor.count_publishers("bench/state") == 2)
    for sequence in range(20):
        for run, bench in enumerate(benches, start=1):
            bench.publish(write_state(run * 10**9 + sequence * 2_000_000, run, sequence, SIGNALS))
            graph.spin_for(0.02)
    graph.spin_until(lambda: streams.told[0] == Level.ERROR)
    assert "more than one node publishes bench/state" in streams.told[1]


def test_a_monitor_that_came_late_tells_what_was_sent_before_it(streams):
    streams.sent = streams.skipped = 40
    streams.send(100)
    assert "; 40 samples of this run were sent before this node received its first" in streams.told[1]
    assert "missing" not in streams.told[1]

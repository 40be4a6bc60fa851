"""Samples that are lost, late, wrong or of two benches: nothing is lost silently, and no node ends."""

import math

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from ros_graph import figures

from ema_bench_replay.errors import InputError
from ema_bench_replay.nodes import qos
from ema_bench_replay.nodes.sample_codec import write_state
from ema_twin_msgs.msg import EmaState, Health, Residual, Run
from ema_twin_sim.live.verdict import Level
from ema_twin_sim.nodes.monitor import MonitorNode
from ema_twin_sim.nodes.twin import TwinNode

PERIOD = 2_000_000
STILL = {"speed_setpoint": 1.0, "speed": 1.0, "current": 0.0, "motor_position": 0.0, "output_position": 0.0}


class Bench:
    """Publishes samples, and hears the twin's answers and what all nodes report."""

    def __init__(self, graph):
        self.node = graph.plain_node()
        self.told = graph.diagnostics(self.node)
        self.answers = []
        self.node.create_subscription(EmaState, "/twin/state", self.answers.append, qos.STATE)
        self.publisher = self.node.create_publisher(EmaState, "/bench/state", qos.STATE)

    def send(self, *sequences, run=1, publisher=None, signals=STILL):
        for sequence in sequences:
            message = write_state(run * 10**9 + sequence * PERIOD, run, sequence, signals)
            (publisher or self.publisher).publish(message)

    def figures(self, name):
        return figures(self.told[name])

    @property
    def of_twin(self):
        """Level and words of the twin's last report."""
        return (self.told["twin"].level, self.told["twin"].message) if "twin" in self.told else (None, "")


@pytest.fixture
def bench(graph):
    return Bench(graph)


def test_lost_late_duplicate_and_backward_samples_are_counted_and_shown(graph, bench):
    graph.add(TwinNode)
    graph.add(MonitorNode)
    bench.send(*range(20), 22, 21, 22, *range(23, 31), run=3)
    bench.publisher.publish(write_state(10**12, 3, 31, STILL))
    bench.send(*range(31, 40), *range(5), 5, 6, run=3)
    taken = [*range(20), *range(22, 40), *range(7)]
    graph.spin_until(lambda: len(bench.answers) == len(taken))
    assert [answer.sequence for answer in bench.answers] == taken
    assert all(answer.run == 3 for answer in bench.answers)
    assert all(answer.header.stamp.nanosec == answer.sequence * PERIOD for answer in bench.answers)
    back = "samples that went back in time"
    graph.spin_until(lambda: {"twin", "monitor"} <= bench.told.keys() and bench.figures("twin")[back] == "1")
    twin = bench.figures("twin")
    counts = ("lost in this run", "that came late", "that came twice", "with a wrong stamp or number")
    assert [twin[f"samples {count}"] for count in counts] == [*"0111"]
    assert twin["runs begun"] == "2"
    graph.spin_until(lambda: bench.figures("monitor")[f"bench {back}"] == "1")
    assert [bench.figures("monitor")[f"bench samples that came {count}"] for count in ("late", "twice")] == ["1", "1"]


def test_no_message_ends_a_node_and_what_was_wrong_is_told(graph, bench):
    """Bytes that are no state, infinite and absurd values: left out of all statistics, counted, and the run goes on.

    A message without any byte is not among them: Fast DDS asks for it over and over, and delivers nothing behind it.
    """
    twin = graph.add(TwinNode)
    monitor = graph.add(MonitorNode)
    bench.send(*range(5))
    bench.send(5, signals={**STILL, "speed_setpoint": math.inf})
    bench.send(6, signals={**STILL, "speed": 1e300})
    bench.send(7, signals={**STILL, "motor_position": -math.inf, "current": 1e200})
    bench.send(8, 9)
    for bytes_ in (b"\0\1\0\0", b"\7", b"\0\1\0\0" + b"\xff" * 60):
        bench.publisher.publish(bytes_)
    bench.send(*range(10, 20))
    graph.spin_until(lambda: len(bench.answers) == 20 and monitor.pairing.compared == 20)
    assert all(math.isfinite(answer.speed) and abs(answer.speed) < 10.0 for answer in bench.answers)
    rmse = monitor.comparison.rmse
    assert all(rmse[name] < 10.0 for name in ("speed", "current", "motor_position")), rmse
    assert twin.failure is None
    told, said = "values on bench/state are infinite or absurd", bench.told
    graph.spin_until(lambda: {"twin", "monitor"} <= said.keys() and all(told in said[n].message for n in said))
    for name, status in said.items():
        assert status.level == DiagnosticStatus.WARN or name == "monitor"
        assert "are no EmaState and were left out" in status.message
        assert bench.figures(name)["values on bench/state that are infinite or absurd"] == "4"
        # the middleware keeps some back
        assert int(bench.figures(name)["messages on bench/state that are no EmaState"]) >= 2


def test_two_benches_mix_and_one_that_was_started_again_does_not(graph, bench):
    """A node that was killed is listed as a publisher for a while: that alone disturbs nothing."""
    graph.add(TwinNode)
    monitor = graph.add(MonitorNode)
    levels = []
    bench.node.create_subscription(Health, "/monitor/health", lambda health: levels.append(health.level), qos.LATEST)
    other = bench.node.create_publisher(EmaState, "/bench/state", qos.STATE)
    bench.send(*range(100))  # the first falls silent, and the second comes
    bench.send(*range(100), run=2, publisher=other)
    graph.spin_until(lambda: monitor.pairing.run == 2 and monitor.pairing.compared == 100)
    assert monitor.count_publishers("/bench/state") == 2 and not monitor.mixed
    for sequence in range(100, 200):
        bench.send(sequence)
        bench.send(sequence, run=2, publisher=other)
    graph.spin_until(lambda: "more than one node publishes bench/state" in monitor.mixed)
    graph.spin_until(lambda: levels and levels[-1] == bytes([Level.ERROR]))
    bench.node.destroy_publisher(other)
    graph.spin_until(lambda: not monitor.mixed)


def test_a_twin_without_its_driving_signal_says_so_and_goes_on(graph, bench):
    twin = graph.add(TwinNode, input="setpoint")
    bench.send(0, signals={name: value for name, value in STILL.items() if name != "speed_setpoint"})
    graph.spin_until(lambda: bench.of_twin[0] == DiagnosticStatus.ERROR)
    assert "speed_setpoint" in bench.of_twin[1]
    bench.send(0, run=2)
    graph.spin_until(lambda: bench.of_twin[0] == DiagnosticStatus.OK)
    assert twin.mode.follower.answered == 1


def test_a_twin_that_came_late_does_not_say_that_it_integrated_across(graph, bench):
    graph.add(TwinNode)
    bench.send(*range(40, 60))
    words = "40 samples of this run were sent before this node received its first; they are not answered"
    graph.spin_until(lambda: bench.of_twin[1] == words)
    counts = bench.figures("twin")
    assert (counts["samples lost in this run"], counts["samples answered"]) == ("0", "20")


def test_a_twin_that_diverges_says_so_and_goes_on_with_the_next_run(graph, bench, stock, monkeypatch):
    twin = graph.add(TwinNode, stock)
    answer = twin.mode.follower.answer

    def diverging(run, sequence, stamp, sample):
        if run == 1 and sequence == 2:
            raise InputError("model polito_bench diverges")
        return answer(run, sequence, stamp, sample)

    monkeypatch.setattr(twin.mode.follower, "answer", diverging)
    bench.send(*range(6))
    graph.spin_until(lambda: "diverges; the twin starts again" in bench.of_twin[1])
    assert bench.of_twin[0] == DiagnosticStatus.ERROR
    bench.send(*range(4), run=2)
    graph.spin_until(lambda: len(bench.answers) == 6)
    assert [(state.run, state.sequence) for state in bench.answers] == [(1, 0), (1, 1), *((2, n) for n in range(4))]
    graph.spin_until(lambda: bench.of_twin[0] == DiagnosticStatus.OK)


def test_a_lost_sample_leaves_the_run_incomplete(graph, bench):
    graph.add(TwinNode)
    monitor = graph.add(MonitorNode)
    healths, residuals = [], []
    bench.node.create_subscription(Health, "/monitor/health", healths.append, qos.LATEST)
    bench.node.create_subscription(Residual, "/monitor/residual", residuals.append, qos.RESIDUAL)
    bench.node.create_publisher(Run, "/bench/run", qos.LATEST).publish(Run(run=4, samples=10))
    graph.spin_until(lambda: monitor.announced)
    bench.send(0, 1, 2, 3, 6, 7, 8, 9, run=4)
    graph.spin_until(lambda: healths and healths[-1].compared == 8)
    assert (healths[-1].missing, healths[-1].expected, healths[-1].complete) == (2, 10, False)
    assert len(residuals) == 8
    assert math.isnan(healths[-1].rmse.unexplained_torque) or healths[-1].rmse.unexplained_torque >= 0.0
    graph.spin_until(lambda: healths[-1].level == Health.STALE)
    assert monitor.pairing.missing == 2
    graph.spin_until(lambda: "2 samples of this run were lost; the twin integrated across" in bench.of_twin[1])

"""Samples that are lost, late, wrong or of two benches: nothing is lost silently, and no node ends."""

import math

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus

from ema_bench_replay.errors import InputError
from ema_bench_replay.nodes import qos
from ema_bench_replay.nodes.sample_codec import write_state
from ema_twin_msgs.msg import EmaState, Health, Residual, Run
from ema_twin_sim.live.verdict import Level
from ema_twin_sim.nodes.monitor import MonitorNode
from ema_twin_sim.nodes.twin import TwinNode

PERIOD = 2_000_000


def bench_signals(value=1.0):
    return {"speed_setpoint": value, "speed": value, "current": 0.0, "motor_position": 0.0, "output_position": 0.0}


def test_lost_late_duplicate_and_backward_samples_are_counted_and_shown(graph):
    graph.add(TwinNode)
    graph.add(MonitorNode)
    tester = graph.plain_node()
    answers, told = [], graph.diagnostics(tester)
    tester.create_subscription(EmaState, "/twin/state", answers.append, qos.STATE)

    def figures(name):
        return {value.key: value.value for value in told[name].values}

    publisher = tester.create_publisher(EmaState, "/bench/state", qos.STATE)
    sequences = [*range(20), 22, 21, 22, *range(23, 40), *range(5), 5, 6]
    for sequence in sequences:
        publisher.publish(write_state(10**9 + sequence * PERIOD, 3, sequence, bench_signals()))
        if sequence == 30:
            publisher.publish(write_state(10**12, 3, 31, bench_signals()))
    taken = [*range(20), *range(22, 40), *range(7)]
    graph.spin_until(lambda: len(answers) == len(taken))
    assert [answer.sequence for answer in answers] == taken
    assert all(answer.run == 3 for answer in answers)
    assert all(answer.header.stamp.nanosec == answer.sequence * PERIOD for answer in answers)
    back = "samples that went back in time"
    graph.spin_until(lambda: {"twin", "monitor"} <= told.keys() and figures("twin")[back] == "1")
    twin = figures("twin")
    counts = ("lost in this run", "that came late", "that came twice", "with a wrong stamp or number")
    assert [twin[f"samples {count}"] for count in counts] == [*"0111"]
    assert twin["runs begun"] == "2"
    graph.spin_until(lambda: figures("monitor")[f"bench {back}"] == "1")
    assert [figures("monitor")[f"bench samples that came {count}"] for count in ("late", "twice")] == ["1", "1"]


def test_no_message_ends_a_node_and_what_was_wrong_is_told(graph):
    """Bytes that are no state, infinite and absurd values: left out of all statistics, counted, and the run goes on.

    A message without any byte is not among them: Fast DDS asks for it over and over, and delivers nothing behind it.
    """
    twin = graph.add(TwinNode)
    monitor = graph.add(MonitorNode)
    tester = graph.plain_node()
    answers, said = [], graph.diagnostics(tester)
    tester.create_subscription(EmaState, "/twin/state", answers.append, qos.STATE)
    publisher = tester.create_publisher(EmaState, "/bench/state", qos.STATE)
    spoilt = {
        5: {"speed_setpoint": math.inf},
        6: {"speed": 1e300},
        7: {"motor_position": -math.inf, "current": 1e200},
    }
    for sequence in range(20):
        if sequence == 10:
            for bytes_ in (b"\0\1\0\0", b"\7", b"\0\1\0\0" + b"\xff" * 60):
                publisher.publish(bytes_)
        signals = bench_signals() | spoilt.get(sequence, {})
        publisher.publish(write_state(10**9 + sequence * PERIOD, 1, sequence, signals))
    graph.spin_until(lambda: len(answers) == 20 and monitor.pairing.compared == 20)
    assert all(math.isfinite(answer.speed) and abs(answer.speed) < 10.0 for answer in answers)
    rmse = monitor.comparison.rmse
    assert all(rmse[name] < 10.0 for name in ("speed", "current", "motor_position")), rmse
    assert twin.failure is None
    told = "values on bench/state are infinite or absurd"
    graph.spin_until(lambda: {"twin", "monitor"} <= said.keys() and all(told in said[n].message for n in said))
    for status in said.values():
        assert status.level == DiagnosticStatus.WARN or status.name.startswith("monitor")
        assert "are no EmaState and were left out" in status.message
        counts = {value.key: value.value for value in status.values}
        assert counts["values on bench/state that are infinite or absurd"] == "4"
        assert int(counts["messages on bench/state that are no EmaState"]) >= 2  # the middleware keeps some back


def test_two_benches_mix_and_one_that_was_started_again_does_not(graph):
    """A node that was killed is listed as a publisher for a while: that alone disturbs nothing."""
    graph.add(TwinNode)
    monitor = graph.add(MonitorNode)
    tester = graph.plain_node()
    levels = []
    tester.create_subscription(Health, "/monitor/health", lambda health: levels.append(health.level), qos.LATEST)
    publishers = [tester.create_publisher(EmaState, "/bench/state", qos.STATE) for _ in range(2)]

    def send(publisher, run, sequence):
        publisher.publish(write_state(run * 10**9 + sequence * PERIOD, run, sequence, bench_signals()))

    for run, publisher in enumerate(publishers, start=1):  # the first falls silent, and the second comes
        for sequence in range(100):
            send(publisher, run, sequence)
    graph.spin_until(lambda: monitor.pairing.run == 2 and monitor.pairing.compared == 100)
    assert monitor.count_publishers("/bench/state") == 2 and not monitor.mixed
    for sequence in range(100, 200):
        for run, publisher in enumerate(publishers, start=1):
            send(publisher, run, sequence)
    graph.spin_until(lambda: "more than one node publishes bench/state" in monitor.mixed)
    graph.spin_until(lambda: levels and levels[-1] == bytes([Level.ERROR]))
    tester.destroy_publisher(publishers[0])
    graph.spin_until(lambda: not monitor.mixed)


def test_a_twin_without_its_driving_signal_says_so_and_goes_on(graph):
    twin = graph.add(TwinNode, input="setpoint")
    tester = graph.plain_node()
    reports = []
    tester.create_subscription(DiagnosticArray, "/diagnostics", reports.append, qos.DIAGNOSTICS)
    publisher = tester.create_publisher(EmaState, "/bench/state", qos.STATE)
    mute = bench_signals()
    del mute["speed_setpoint"]
    publisher.publish(write_state(10**9, 1, 0, mute))
    graph.spin_until(lambda: reports and reports[-1].status[0].level == DiagnosticStatus.ERROR)
    assert "speed_setpoint" in reports[-1].status[0].message
    publisher.publish(write_state(10**9, 2, 0, bench_signals()))
    graph.spin_until(lambda: reports[-1].status[0].level == DiagnosticStatus.OK)
    assert twin.mode.follower.answered == 1


def test_a_twin_that_came_late_does_not_say_that_it_integrated_across(graph):
    graph.add(TwinNode)
    tester = graph.plain_node()
    reports = []
    tester.create_subscription(DiagnosticArray, "/diagnostics", reports.append, qos.DIAGNOSTICS)
    publisher = tester.create_publisher(EmaState, "/bench/state", qos.STATE)
    for sequence in range(40, 60):
        publisher.publish(write_state(10**9 + sequence * PERIOD, 1, sequence, bench_signals()))
    words = "40 samples of this run were sent before this node received its first; they are not answered"
    graph.spin_until(lambda: reports and reports[-1].status[0].message == words)
    counts = {value.key: value.value for value in reports[-1].status[0].values}
    assert (counts["samples lost in this run"], counts["samples answered"]) == ("0", "20")


def test_a_twin_that_diverges_says_so_and_goes_on_with_the_next_run(graph, stock, monkeypatch):
    twin = graph.add(TwinNode, stock)
    tester = graph.plain_node()
    reports, answers = [], []
    tester.create_subscription(DiagnosticArray, "/diagnostics", reports.append, qos.DIAGNOSTICS)
    tester.create_subscription(EmaState, "/twin/state", answers.append, qos.STATE)
    publisher = tester.create_publisher(EmaState, "/bench/state", qos.STATE)
    answer = twin.mode.follower.answer

    def diverging(run, sequence, stamp, sample):
        if run == 1 and sequence == 2:
            raise InputError("model polito_bench diverges")
        return answer(run, sequence, stamp, sample)

    monkeypatch.setattr(twin.mode.follower, "answer", diverging)
    for run, sequence in [*((1, n) for n in range(6)), *((2, n) for n in range(4))]:
        publisher.publish(write_state(run * 10**9 + sequence * PERIOD, run, sequence, bench_signals()))
        if (run, sequence) == (1, 5):
            graph.spin_until(lambda: reports and "diverges; the twin starts again" in reports[-1].status[0].message)
            assert reports[-1].status[0].level == DiagnosticStatus.ERROR
    graph.spin_until(lambda: len(answers) == 6)
    assert [(state.run, state.sequence) for state in answers] == [(1, 0), (1, 1), *((2, n) for n in range(4))]
    graph.spin_until(lambda: reports[-1].status[0].level == DiagnosticStatus.OK)


def test_a_lost_sample_leaves_the_run_incomplete(graph):
    graph.add(TwinNode)
    monitor = graph.add(MonitorNode)
    tester = graph.plain_node()
    healths, residuals = [], []
    tester.create_subscription(Health, "/monitor/health", healths.append, qos.LATEST)
    tester.create_subscription(Residual, "/monitor/residual", residuals.append, qos.RESIDUAL)
    tester.create_publisher(Run, "/bench/run", qos.LATEST).publish(Run(run=4, samples=10))
    publisher = tester.create_publisher(EmaState, "/bench/state", qos.STATE)
    graph.spin_until(lambda: monitor.announced)
    for sequence in (0, 1, 2, 3, 6, 7, 8, 9):
        publisher.publish(write_state(10**9 + sequence * PERIOD, 4, sequence, bench_signals()))
    graph.spin_until(lambda: healths and healths[-1].compared == 8)
    assert (healths[-1].missing, healths[-1].expected, healths[-1].complete) == (2, 10, False)
    assert len(residuals) == 8
    assert math.isnan(healths[-1].rmse.unexplained_torque) or healths[-1].rmse.unexplained_torque >= 0.0
    graph.spin_until(lambda: healths[-1].level == Health.STALE)
    assert monitor.pairing.missing == 2

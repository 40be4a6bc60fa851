"""The nodes on a real ROS graph: live equals compare, parameters act or are refused, nothing is lost silently."""

import math
import re
import threading
import time

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rcl_interfaces.srv import DescribeParameters, SetParameters
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger

from ema_bench_replay.bags.bag_reader import read_bag
from ema_bench_replay.errors import InputError
from ema_bench_replay.load import load
from ema_bench_replay.nodes import qos
from ema_bench_replay.nodes.record import RecordNode
from ema_bench_replay.nodes.replay import ReplayNode
from ema_bench_replay.nodes.sample_codec import write_state
from ema_twin_msgs.msg import EmaState, Health, Residual, Run
from ema_twin_msgs.srv import Seek
from ema_twin_sim.comparison.compare import compare
from ema_twin_sim.live.verdict import Level
from ema_twin_sim.model import load_model
from ema_twin_sim.nodes.live import Change, run_live
from ema_twin_sim.nodes.monitor import MonitorNode
from ema_twin_sim.nodes.twin import TwinNode

PERIOD = 2_000_000


@pytest.fixture(scope="module")
def recording(traces):
    return load(next(path for path in traces if "triangle" in path.name))


@pytest.fixture(scope="module")
def model():
    return load_model("polito_bench")


def assert_same(live, recording, model):
    offline = compare([recording], model).recordings[0].signals
    assert live.keys() == offline.keys()
    for name, figures in offline.items():
        assert live[name]["rmse"] == pytest.approx(figures["rmse"], rel=1e-6, abs=0.0), name
        assert live[name]["relative"] == pytest.approx(figures["relative"], rel=1e-6), name
        assert live[name]["driven"] == figures["driven"]


@pytest.mark.parametrize(("rate", "seconds"), [(0.0, None), (5.0, 4.0), (1.0, 1.0)])
def test_live_equals_compare(recording, model, rate, seconds):
    part = recording.between(0.0, seconds)
    pairs = []
    live = run_live(part, model, rate=rate, on_pairs=pairs.extend)
    assert live.complete
    assert live.counts == {"sent": len(part), "compared": len(part), "missing": 0, "expected": len(part)}
    assert_same(live.signals, part, model)
    assert [pair.stamp for pair in pairs] == [part.start + stamp for stamp in part.stamps.tolist()]


def test_pause_and_seek_back_change_nothing(graph, recording, model):
    twin = graph.add(TwinNode, model)
    monitor = graph.add(MonitorNode, model)
    replay = graph.add(ReplayNode, recording, rate=10.0, on_end="wait")
    tester = graph.plain_node()
    runs = []
    tester.create_subscription(Run, "/bench/run", runs.append, qos.LATEST)
    graph.spin_until(lambda: monitor.pairing.compared > 500)
    assert graph.call(tester, Trigger, "/replay/pause").success
    run = replay.run
    graph.spin_for(0.1)
    stood_at = replay.sent
    graph.spin_for(0.2)
    assert replay.sent == stood_at
    assert graph.call(tester, Trigger, "/replay/step").success
    graph.spin_until(lambda: replay.sent == stood_at + 1)
    assert graph.call(tester, Trigger, "/replay/resume").success
    graph.spin_until(lambda: replay.sent > stood_at + 100)
    assert replay.run == run
    refused = graph.call(tester, Seek, "/replay/seek", position=1e3)
    assert not refused.success
    assert f"0 to {recording.duration:g} s" in refused.message
    (answer,) = replay.set_parameters([Parameter("rate", value=-1.0)])
    assert not answer.successful
    assert replay.set_parameters([Parameter("rate", value=20)])[0].successful
    assert graph.call(tester, Seek, "/replay/seek", position=0.0).success
    graph.spin_until(lambda: replay.ended and monitor.complete)
    assert replay.run != run
    assert_same(monitor.comparison.result(), recording, model)
    assert [message.run for message in runs] == [run, replay.run]
    assert all(message.samples == len(recording) for message in runs)
    assert twin.get_parameter("effects.backlash.enabled").value is False


def test_a_run_that_starts_later_equals_that_part(graph, recording, model):
    graph.add(TwinNode, model)
    monitor = graph.add(MonitorNode, model)
    replay = graph.add(ReplayNode, recording, rate=0.0, on_end="wait", start=15.0)
    graph.spin_until(lambda: replay.ended and monitor.complete)
    assert_same(monitor.comparison.result(), recording.between(15.0), model)


def test_an_effect_switched_on_acts_while_running(recording, model):
    part = recording.between(0.0, 3.0)
    pairs = []
    changes = [
        Change(1.0, "effects.stribeck_friction.torque", 0.5),
        Change(1.0, "effects.stribeck_friction.speed", 20),
        Change(1.5, "effects.stribeck_friction.enabled", True),
    ]
    changed = run_live(part, model, rate=5.0, changes=changes, on_pairs=pairs.extend)
    plain = compare([part], model).recordings[0].signals
    assert changed.complete
    assert changed.signals["current"]["rmse"] > 2.0 * plain["current"]["rmse"]
    early = [abs(pair.residuals["current"]) for pair in pairs[:700]]
    late = [abs(pair.residuals["current"]) for pair in pairs[-500:]]
    assert sum(late) / len(late) > 3.0 * sum(early) / len(early)


def test_parameters_are_described_set_and_refused_with_their_range(graph):
    twin = graph.add(TwinNode)
    tester = graph.plain_node()
    names = ["effects.backlash.width", "drive.speed_gain", "effects.sun_runout.enabled"]
    described = graph.call(tester, DescribeParameters, "/twin/describe_parameters", names=names).descriptors
    assert "[N m s/rad]" in described[1].description
    assert described[1].floating_point_range[0].from_value == 0.0
    assert all(len(descriptor.description) > 10 for descriptor in described)

    def set_parameters(**values):
        given = [Parameter(name.replace("__", "."), value=value).to_parameter_msg() for name, value in values.items()]
        return graph.call(tester, SetParameters, "/twin/set_parameters", parameters=given).results

    (answer,) = set_parameters(effects__backlash__width=-1.0)
    assert not answer.successful
    assert "Min: 0.0" in answer.reason
    (answer,) = set_parameters(effects__backlash__width=-1)
    assert not answer.successful
    assert "give 0 to" in answer.reason
    (answer,) = set_parameters(effects__backlash__enabled="yes")
    assert not answer.successful
    assert "true or false" in answer.reason
    assert all(answer.successful for answer in set_parameters(effects__backlash__width=0.01, drive__speed_gain=1))
    changed = twin.mode.twin
    assert changed.effects["backlash"].parameters["width"] == 0.01
    assert changed.model.value("drive.speed_gain") == 1.0
    assert not changed.effects["backlash"].enabled
    (answer,) = set_parameters(model="other")
    assert not answer.successful


def test_start_values_of_parameters_reach_the_model(graph):
    twin = graph.add(TwinNode, **{"effects.backlash.enabled": True, "machine.motor_inertia": 2e-3})
    assert twin.mode.twin.effects["backlash"].enabled
    assert twin.mode.twin.model.value("machine.motor_inertia") == 2e-3


def bench_signals(value=1.0):
    return {"speed_setpoint": value, "speed": value, "current": 0.0, "motor_position": 0.0, "output_position": 0.0}


def test_lost_late_duplicate_and_backward_samples_are_counted_and_shown(graph):
    graph.add(TwinNode)
    graph.add(MonitorNode)
    tester = graph.plain_node()
    answers, reports = [], {}
    tester.create_subscription(EmaState, "/twin/state", answers.append, qos.STATE)

    def keep(message):
        for status in message.status:
            reports[status.name.split(":")[0]] = {value.key: value.value for value in status.values} | {
                "level": status.level
            }

    tester.create_subscription(DiagnosticArray, "/diagnostics", keep, qos.DIAGNOSTICS)
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
    graph.spin_until(lambda: {"twin", "monitor"} <= reports.keys() and reports["twin"][back] == "1")
    twin = reports["twin"]
    counts = ("lost in this run", "that came late", "that came twice", "with a wrong stamp or number")
    assert [twin[f"samples {count}"] for count in counts] == [*"0111"]
    assert twin["runs begun"] == "2"
    graph.spin_until(lambda: reports["monitor"][f"bench {back}"] == "1")
    assert [reports["monitor"][f"bench samples that came {count}"] for count in ("late", "twice")] == ["1", "1"]


def test_no_message_ends_a_node_and_what_was_wrong_is_told(graph):
    """Bytes that are no state, infinite and absurd values: left out of all statistics, counted, and the run goes on."""
    twin = graph.add(TwinNode)
    monitor = graph.add(MonitorNode)
    tester = graph.plain_node()
    answers, said = [], {}
    tester.create_subscription(EmaState, "/twin/state", answers.append, qos.STATE)

    def keep(message):
        said.update((status.name.split(":")[0], status) for status in message.status)

    tester.create_subscription(DiagnosticArray, "/diagnostics", keep, qos.DIAGNOSTICS)
    publisher = tester.create_publisher(EmaState, "/bench/state", qos.STATE)
    spoilt = {
        5: {"speed_setpoint": math.inf},
        6: {"speed": 1e300},
        7: {"motor_position": -math.inf, "current": 1e200},
    }
    for sequence in range(20):
        if sequence == 10:
            for bytes_ in (b"\0\1\0\0", b"", b"\7", b"\0\1\0\0" + b"\xff" * 60):
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
    words = "40 samples of this run were sent before the first that came here; they are not answered"
    graph.spin_until(lambda: reports and reports[-1].status[0].message == words)
    counts = {value.key: value.value for value in reports[-1].status[0].values}
    assert (counts["samples lost in this run"], counts["samples answered"]) == ("0", "20")


def test_a_twin_that_diverges_says_so_and_goes_on_with_the_next_run(graph, model, monkeypatch):
    twin = graph.add(TwinNode, model)
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


def test_health_goes_by_the_noise_floor(graph, recording, model):
    graph.add(TwinNode, model)
    monitor = graph.add(MonitorNode, model, error_at=1e6, warn_at=1e5)
    tester = graph.plain_node()
    healths = []
    tester.create_subscription(Health, "/monitor/health", healths.append, qos.LATEST)
    replay = graph.add(ReplayNode, recording.between(0.0, 2.0), rate=0.0, on_end="wait")
    graph.spin_until(lambda: replay.ended and monitor.complete)
    graph.spin_until(lambda: healths and healths[-1].complete)
    assert healths[-1].level == Health.OK
    assert healths[-1].noise_floor.current == pytest.approx(0.003)
    assert healths[-1].rmse_window.current == pytest.approx(healths[-1].rmse.current)
    monitor.set_parameters([Parameter("warn_at", value=1.0), Parameter("error_at", value=1e6)])
    graph.spin_until(lambda: healths[-1].level == Health.WARN)
    monitor.set_parameters([Parameter("error_at", value=2)])
    graph.spin_until(lambda: healths[-1].level == Health.ERROR)


@pytest.mark.parametrize("rate", [500.0, 1000.0])
def test_a_standalone_twin_keeps_real_time(graph, rate):
    """How few periods a busy machine misses is measured by the benchmark of the nodes."""
    began = time.time_ns()
    twin = graph.add(TwinNode, input="standalone", command="sine:0.02:1", rate=rate)
    tester = graph.plain_node()
    samples = []
    tester.create_subscription(EmaState, "/twin/state", samples.append, qos.STATE)
    graph.spin_until(lambda: samples and stamp_of(samples[-1]) - stamp_of(samples[0]) > 1.2e9)
    period = 1e9 / rate  # a sample may be up to half of it early
    assert began < stamp_of(samples[0]) <= stamp_of(samples[-1]) < time.time_ns() + period
    elapsed = [(stamp_of(sample) - stamp_of(samples[0])) * rate * 1e-9 for sample in samples]
    assert all(abs(periods - round(periods)) < 1e-6 for periods in elapsed)
    assert [sample.sequence for sample in samples] == list(range(len(samples)))
    missed = round(elapsed[-1]) + 1 - len(samples)
    assert 0 <= missed <= twin.mode.deadlines.missed
    assert max(abs(sample.output_position) for sample in samples) == pytest.approx(0.02, rel=0.2)


def stamp_of(sample):
    return sample.header.stamp.sec * 10**9 + sample.header.stamp.nanosec


def test_everything_is_recorded(recording, model, tmp_path):
    part = recording.between(0.0, 2.0)
    live = run_live(part, model, rate=0.0, record_to=tmp_path / "bag")
    assert live.complete
    bench, twin = read_bag(tmp_path / "bag"), read_bag(tmp_path / "bag", topic="/twin/state")
    assert len(bench) == len(twin) == len(part)
    for name, values in part.signals.items():
        assert (bench.signals[name] == values).all(), name
    assert bench.start == part.start
    assert bench.motor_angle_origin == part.motor_angle_origin


def test_live_ends_when_told(recording, model):
    stop = threading.Event()
    live = run_live(recording, model, rate=1.0, on_pairs=lambda pairs: stop.set(), stop=stop)
    assert not live.complete
    assert 0 < live.samples < len(recording)


def test_every_report_reads_as_a_sentence_and_figures_with_units(graph, recording, model, tmp_path):
    nodes = [graph.add(TwinNode, model), graph.add(MonitorNode, model)]
    nodes.append(graph.add(RecordNode, output=str(tmp_path / "bag")))
    nodes.append(graph.add(ReplayNode, recording.between(0.0, 2.0), rate=0.0, on_end="wait", subscribers=3))
    graph.spin_until(lambda: nodes[-1].ended and nodes[1].complete)
    reports = {node.get_name(): node._report() for node in nodes}
    for name, report in reports.items():
        assert report.message and "\n" not in report.message and "_" not in report.message, name
        for key, value in report.values.items():
            assert not isinstance(value, float), f"{name}: {key} is a number without a unit"
            assert not re.search(r"\d\.\d{5}", str(value)), f"{name}: {key} has digits that mean nothing"
    assert reports["replay"].values["position"] == "2.00 of 2.00 s"
    error = reports["monitor"].values["RMSE of the output position"]
    assert re.fullmatch(r"\d\.\d\d mrad, \d{3} times the noise floor", error)
    assert reports["monitor"].values["missing effect"] == "not asked yet: call monitor/diagnose"
    assert reports["record"].values["/bench/state"].endswith(" messages written")
    assert reports["twin"].values["computes at"].endswith(" × real time")

"""The nodes on a real ROS graph: live equals compare, parameters act or are refused."""

import re
import threading
import time

import pytest
from rcl_interfaces.srv import DescribeParameters, SetParameters
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger

from ema_bench_replay.bags.bag_reader import read_bag
from ema_bench_replay.load import load
from ema_bench_replay.nodes import qos
from ema_bench_replay.nodes.record import RecordNode
from ema_bench_replay.nodes.replay import ReplayNode
from ema_twin_msgs.msg import EmaState, Health, Run
from ema_twin_msgs.srv import Seek
from ema_twin_sim.comparison.compare import compare
from ema_twin_sim.nodes.live import run_live
from ema_twin_sim.nodes.live_session import Change
from ema_twin_sim.nodes.monitor import MonitorNode
from ema_twin_sim.nodes.twin import TwinNode


@pytest.fixture(scope="module")
def recording(traces):
    return load(next(path for path in traces if "triangle" in path.name))


def assert_same(live, recording, stock):
    offline = compare([recording], stock).recordings[0].signals
    assert live.keys() == offline.keys()
    for name, figures in offline.items():
        assert live[name]["rmse"] == pytest.approx(figures["rmse"], rel=1e-6, abs=0.0), name
        assert live[name]["relative"] == pytest.approx(figures["relative"], rel=1e-6), name
        assert live[name]["driven"] == figures["driven"]


@pytest.mark.parametrize(("rate", "seconds"), [pytest.param(0.0, None, marks=pytest.mark.slow), (5.0, 4.0), (1.0, 1.0)])
def test_live_equals_compare(recording, stock, rate, seconds):
    part = recording.between(0.0, seconds)
    pairs = []
    live = run_live(part, stock, rate=rate, on_pairs=pairs.extend)
    assert live.complete
    assert live.counts == {"sent": len(part), "compared": len(part), "missing": 0, "expected": len(part)}
    assert_same(live.signals, part, stock)
    assert [pair.stamp for pair in pairs] == [part.start + stamp for stamp in part.stamps.tolist()]


@pytest.mark.slow
def test_pause_and_seek_back_change_nothing(graph, recording, stock):
    recording = recording.between(0.0, 5.0)
    twin = graph.add(TwinNode, stock)
    monitor = graph.add(MonitorNode, stock)
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
    assert_same(monitor.comparison.result(), recording, stock)
    assert [message.run for message in runs] == [run, replay.run]
    assert all(message.samples == len(recording) for message in runs)
    assert twin.get_parameter("effects.backlash.enabled").value is False


def test_a_run_that_starts_later_equals_that_part(graph, recording, stock):
    graph.add(TwinNode, stock)
    monitor = graph.add(MonitorNode, stock)
    replay = graph.add(ReplayNode, recording, rate=0.0, on_end="wait", start=17.0)
    graph.spin_until(lambda: replay.ended and monitor.complete)
    assert_same(monitor.comparison.result(), recording.between(17.0), stock)


@pytest.mark.slow
def test_an_effect_switched_on_acts_while_running(recording, stock):
    part = recording.between(0.0, 3.0)
    pairs = []
    changes = [
        Change(1.0, "effects.stribeck_friction.torque", 0.5),
        Change(1.0, "effects.stribeck_friction.speed", 20),
        Change(1.5, "effects.stribeck_friction.enabled", True),
    ]
    changed = run_live(part, stock, rate=5.0, changes=changes, on_pairs=pairs.extend)
    plain = compare([part], stock).recordings[0].signals
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


def test_an_option_accepts_what_the_catalogue_does(graph):
    """Any positive order, as text or as the number that `ros2 param set` makes of it, as `add --set order=22` does."""
    twin = graph.add(TwinNode, **{"effects.mesh_ripple.order": "2.5"})
    tester = graph.plain_node()

    def set_order(value):
        given = [Parameter("effects.cogging.order", value=value).to_parameter_msg()]
        (answer,) = graph.call(tester, SetParameters, "/twin/set_parameters", parameters=given).results
        return answer

    assert twin.mode.twin.effects["mesh_ripple"].options["order"] == "2.5"
    for order in ("22", 23, 24):
        assert set_order(order).successful
        assert twin.mode.twin.effects["cogging"].options["order"] == str(order)
    for wrong in ("-1", 0, "many", True):
        answer = set_order(wrong)
        assert not answer.successful and answer.reason.endswith("or another positive number")
    assert twin.mode.twin.effects["cogging"].options["order"] == "24"


def test_start_values_of_parameters_reach_the_model(graph):
    twin = graph.add(TwinNode, **{"effects.backlash.enabled": True, "machine.motor_inertia": 2e-3})
    assert twin.mode.twin.effects["backlash"].enabled
    assert twin.mode.twin.model.value("machine.motor_inertia") == 2e-3


def test_health_goes_by_the_noise_floor(graph, recording, stock):
    graph.add(TwinNode, stock)
    monitor = graph.add(MonitorNode, stock, error_at=1e6, warn_at=1e5)
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


def test_everything_is_recorded(recording, stock, tmp_path):
    part = recording.between(0.0, 2.0)
    live = run_live(part, stock, rate=0.0, record_to=tmp_path / "bag")
    assert live.complete
    bench, twin = read_bag(tmp_path / "bag"), read_bag(tmp_path / "bag", topic="/twin/state")
    assert len(bench) == len(twin) == len(part)
    for name, values in part.signals.items():
        assert (bench.signals[name] == values).all(), name
    assert bench.start == part.start
    assert bench.motor_angle_origin == part.motor_angle_origin


def test_live_ends_when_told(recording, stock):
    stop = threading.Event()
    live = run_live(recording, stock, rate=1.0, on_pairs=lambda pairs: stop.set(), stop=stop)
    assert not live.complete
    assert 0 < live.samples < len(recording)


def test_every_report_reads_as_a_sentence_and_figures_with_units(graph, recording, stock, tmp_path):
    nodes = [graph.add(TwinNode, stock), graph.add(MonitorNode, stock)]
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
    assert reports["monitor"].values["missing effect"] == "no diagnosis yet: call monitor/diagnose"
    assert reports["record"].values["/bench/state"].endswith(" messages written")
    assert reports["twin"].values["computes at"].endswith(" × real time")

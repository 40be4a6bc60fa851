"""The monitor's services on a real ROS graph, seen from topics and services only: ask, add, and the error falls."""

import os
import time

import pytest
from rcl_interfaces.srv import GetParameters, SetParameters
from rclpy.parameter import Parameter
from ros_graph import Graph, start_process

from ema_bench_replay.nodes import qos
from ema_twin_msgs.msg import Diagnosis, Health, Residual
from ema_twin_msgs.srv import Apply, Diagnose
from tests.conftest import outside

pytestmark = pytest.mark.timeout(400)

NODES = ("ema_twin_sim.nodes.twin", "ema_twin_sim.nodes.monitor")
PATIENCE = 90.0
"""s that a diagnosis may take here: other tests run beside it. How long it takes alone, the benchmark tells."""

GONE = 0.1
"""Share of the squared error above the noise that may stay. The numbers that a diagnosis finds differ a little with the
window that it is asked in, and impacts amplify that; without the effects the share would be 1."""


class Bench:
    """Twin, monitor and a replay that loops, each a process; and a node that listens."""

    def __init__(self, recording):
        self.processes = [start_process(module) for module in NODES]
        played = (f"recording:={recording}", "loop:=true", "subscribers:=2")
        self.processes.append(start_process("ema_bench_replay.nodes.replay", *played))
        self.graph = Graph()
        self.node = self.graph.plain_node()
        self.health, self.residuals, self.diagnoses = [], [], []
        self.node.create_subscription(Health, "/monitor/health", self.health.append, qos.LATEST)
        self.node.create_subscription(Residual, "/monitor/residual", self.residuals.append, qos.RESIDUAL)
        self.node.create_subscription(Diagnosis, "/monitor/diagnosis", self.diagnoses.append, qos.LATEST)

    def compared(self, samples):
        """Wait until the present run has compared so many."""
        self.graph.spin_until(lambda: self.health and self.health[-1].compared > samples, PATIENCE)

    def whole_run(self):
        """The last health of the next run that begins: RMSE over the whole recording, but for its last 0.1 s."""
        for _ in range(2):
            present = self.health[-1].run
            self.graph.spin_until(lambda run=present: self.health[-1].run != run, PATIENCE)
        return next(health for health in reversed(self.health) if health.run == present)

    def play_at(self, rate):
        wanted = Parameter("rate", value=rate).to_parameter_msg()
        assert self.answer(self.ask(SetParameters, "/replay/set_parameters", parameters=[wanted])).results[0].successful

    def ask(self, service, name, **request):
        client = self.node.create_client(service, name)
        assert client.wait_for_service(timeout_sec=30.0)
        return client.call_async(service.Request(**request))

    def answer(self, future):
        self.graph.spin_until(future.done, PATIENCE)
        return future.result()

    def close(self):
        self.graph.close()
        for process in self.processes:
            process.terminate()
        for process in self.processes:
            _, errors = process.communicate(timeout=20.0)
            assert process.returncode == 0 and "Traceback" not in errors, errors


@pytest.fixture
def bench(request, traces):
    os.environ.pop("ROS_NAMESPACE", None)
    bench = Bench(request.param(traces))
    yield bench
    bench.close()


def own(traces):
    return next(path for path in traces if "sine_0.05" in path.name)


def dev10(traces):
    return next((outside("bench_cases") / "dev10" / "train").glob("*sine*"))


@pytest.mark.parametrize("bench", [own, dev10], indirect=True)
def test_what_is_missing_is_named_added_and_the_error_falls(bench):
    bench.compared(4500)
    run, first = bench.residuals[-1].run, bench.residuals[-1].sequence
    asked = time.monotonic()
    future = bench.ask(Diagnose, "/monitor/diagnose")
    bench.graph.spin_for(0.3)
    second = bench.answer(bench.ask(Diagnose, "/monitor/diagnose"))
    assert not second.success and "is being made" in second.message  # refused at once, not queued
    found = bench.answer(future)
    lasted = time.monotonic() - asked
    assert found.success, found.message
    diagnosis = found.diagnosis
    assert diagnosis.verdict in {entry.id for entry in diagnosis.ranking if entry.found}
    total = sum(entry.probability for entry in diagnosis.ranking) + diagnosis.none + diagnosis.unknown
    assert total == pytest.approx(1.0)
    assert diagnosis.window > 8.0
    bench.graph.spin_until(lambda: bench.diagnoses)
    assert str(bench.diagnoses[-1]) == str(diagnosis)  # with NaN in it, it does not equal itself

    # the stream went on meanwhile: 500 samples a second, none of them missing
    judged = [residual for residual in bench.residuals if (residual.run, residual.sequence) > (run, first)]
    assert len(judged) > 0.9 * 500.0 * lasted - 500.0
    assert all(health.missing == 0 for health in bench.health)

    bench.play_at(3.0)
    before = bench.whole_run()
    added = bench.answer(bench.ask(Apply, "/monitor/apply"))
    assert added.success and diagnosis.verdict in added.message
    after = bench.whole_run()
    for signal in ("current", "output_position"):
        excess = [
            getattr(health.rmse, signal) ** 2 - getattr(health.noise_floor, signal) ** 2 for health in (before, after)
        ]
        assert excess[1] < GONE * excess[0], signal

    bench.play_at(1.0)
    again = bench.answer(bench.ask(Diagnose, "/monitor/diagnose")).diagnosis
    assert again.verdict == "none" and not [entry for entry in again.ranking if entry.found]


@pytest.mark.parametrize("bench", [own], indirect=True)
def test_what_the_services_refuse_and_that_one_may_go_back(bench):
    refused = bench.answer(bench.ask(Apply, "/monitor/apply"))
    assert not refused.success and "nothing was diagnosed yet" in refused.message
    bench.compared(100)
    refused = bench.answer(bench.ask(Diagnose, "/monitor/diagnose", window=-1.0))
    assert not refused.success and "window -1" in refused.message
    refused = bench.answer(bench.ask(Diagnose, "/monitor/diagnose", window=0.05))
    assert not refused.success and "seconds" in refused.message
    bench.compared(4500)
    assert bench.answer(bench.ask(Diagnose, "/monitor/diagnose")).success
    refused = bench.answer(bench.ask(Apply, "/monitor/apply", effect=["no_such_effect"]))
    assert not refused.success and "no_such_effect" in refused.message
    assert bench.answer(bench.ask(Apply, "/monitor/apply", effect=["backlash"])).success

    def backlash():
        names = ["effects.backlash.enabled", "effects.stribeck_friction.enabled"]
        return [
            held.bool_value
            for held in bench.answer(bench.ask(GetParameters, "/twin/get_parameters", names=names)).values
        ]

    assert backlash() == [True, False]
    off = Parameter("effects.backlash.enabled", value=False).to_parameter_msg()
    assert bench.answer(bench.ask(SetParameters, "/twin/set_parameters", parameters=[off])).results[0].successful
    assert backlash() == [False, False]
    found = bench.answer(bench.ask(Diagnose, "/monitor/diagnose")).diagnosis
    assert "backlash" in {entry.id for entry in found.ranking if entry.found}

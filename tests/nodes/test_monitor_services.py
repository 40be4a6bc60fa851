"""The monitor's services on a real ROS graph, seen from topics and services only: ask, add, and the error falls."""

import os
from itertools import pairwise

import pytest
from rcl_interfaces.srv import GetParameters, SetParameters
from rclpy.parameter import Parameter
from ros_graph import Graph, ended_well, start_process
from std_srvs.srv import Trigger

from ema_bench_replay.nodes import qos
from ema_twin_msgs.msg import Diagnosis, EmaState, Health, Residual
from ema_twin_msgs.srv import Apply, Diagnose
from tests.command_line import ENDING

pytestmark = pytest.mark.timeout(900)

NODES = ("ema_twin_sim.nodes.twin", "ema_twin_sim.nodes.monitor")
PATIENCE = 240.0
"""s that a diagnosis may take here: other tests run beside it. How long it takes alone, the benchmark tells."""

GONE = 0.1
"""Share of the squared error above the noise that may stay. The numbers that a diagnosis finds differ a little with the
window that it is asked in, and impacts amplify that; without the effects the share would be 1."""

SOONER = 3.0
"""Times real time that is played where samples are only waited for. A diagnosis is made beside a bench in real time."""

START = "start:=4.0"
"""Of five periods the first is left out: whole runs are played to their ends, for each node to take part in."""

STREAM = 50
"""Residuals that come while a diagnosis is made, at the least: 0.1 s of them, where one takes a second or more."""


class Bench:
    """Twin, monitor and a replay that loops, each a process; and a node that listens."""

    def __init__(self, recording):
        self.processes = [start_process(module) for module in NODES]
        played = (f"recording:={recording}", START, "loop:=true", "subscribers:=2", "patience:=60.0")
        self.processes.append(start_process("ema_bench_replay.nodes.replay", *played))
        self.graph = Graph()
        self.node = self.graph.plain_node()
        self.clients = {}
        self.health, self.residuals, self.diagnoses = [], [], []
        self.node.create_subscription(Health, "/monitor/health", self.health.append, qos.LATEST)
        # all are kept until they are read here, however late: what is missing is the monitor's fault
        self.node.create_subscription(Residual, "/monitor/residual", self.residuals.append, qos.STATE_FROM_NOW)
        self.node.create_subscription(Diagnosis, "/monitor/diagnosis", self.diagnoses.append, qos.LATEST)

    def compared(self, samples):
        """Wait until the present run has compared so many; its number."""
        self.sooner(lambda: self.health and self.health[-1].compared > samples)
        return self.health[-1].run

    def whole_run(self, number):
        """The last health of that run, when it is over: RMSE over the whole recording, but for its last 0.3 s."""
        self.sooner(lambda: self.health[-1].run > number)
        return next(health for health in reversed(self.health) if health.run == number)

    def sooner(self, condition):
        """Wait for that, with samples that come sooner meanwhile."""
        self.play(SOONER)
        self.graph.spin_until(condition, PATIENCE)
        self.play(1.0)

    def play(self, rate):
        asked = [Parameter("rate", value=rate).to_parameter_msg()]
        assert self.answer(self.ask(SetParameters, "/replay/set_parameters", parameters=asked)).results[0].successful

    def diagnosed_at_rest(self):
        """The answer of a diagnosis for which no more samples come: then the nodes take no time from it."""
        assert self.answer(self.ask(Trigger, "/replay/pause")).success
        told = self.answer(self.ask(Diagnose, "/monitor/diagnose"))
        assert told.success, told.message
        assert self.answer(self.ask(Trigger, "/replay/resume")).success
        return told.diagnosis

    def run_of_twin(self):
        """The run that the twin answers now; the monitor may still compare what it answered before."""
        answers = []
        heard = self.node.create_subscription(EmaState, "/twin/state", answers.append, qos.STATE_FROM_NOW)
        self.graph.spin_until(lambda: answers, PATIENCE)
        self.node.destroy_subscription(heard)
        return answers[0].run

    def ask(self, service, name, **request):
        if name not in self.clients:
            self.clients[name] = self.node.create_client(service, name)
        assert self.clients[name].wait_for_service(timeout_sec=ENDING)
        return self.clients[name].call_async(service.Request(**request))

    def answer(self, future):
        self.graph.spin_until(future.done, PATIENCE, "a service's answer")
        return future.result()

    def close(self):
        self.graph.close()
        for process in self.processes:
            process.terminate()
        for process in self.processes:
            _, errors = process.communicate(timeout=ENDING)
            assert ended_well(process, errors) and "Traceback" not in errors, errors


@pytest.fixture
def bench(request, traces):
    os.environ.pop("ROS_NAMESPACE", None)
    bench = Bench(request.param(traces))
    yield bench
    bench.close()


def effects_found(diagnosis):
    """With their options: of another kind, an effect is another."""
    return {(entry.id, tuple(entry.option)) for entry in diagnosis.ranking if entry.found}


def own(traces):
    return next(path for path in traces if "sine_0.05" in path.name)


@pytest.mark.slow
@pytest.mark.parametrize("bench", [own], indirect=True)
def test_what_is_missing_is_named_added_and_the_error_falls(bench):
    run = bench.compared(4500)
    asked = len(bench.residuals)
    futures = [bench.ask(Diagnose, "/monitor/diagnose") for _ in range(2)]
    # whichever came second is refused at once, not queued
    refused, found = sorted(map(bench.answer, futures), key=lambda answer: answer.success)
    answered = len(bench.residuals)
    assert not refused.success and "is in progress" in refused.message
    assert found.success, found.message
    diagnosis = found.diagnosis
    assert diagnosis.verdict in {entry.id for entry in diagnosis.ranking if entry.found}
    assert all(entry.probability > 0.9 for entry in diagnosis.ranking if entry.found)
    assert diagnosis.none < 0.1 and diagnosis.unknown < 0.1
    assert diagnosis.window > 8.0
    bench.graph.spin_until(lambda: bench.diagnoses)
    assert str(bench.diagnoses[-1]) == str(diagnosis)  # with NaN in it, it does not equal itself

    # the stream went on meanwhile, and none of it is missing: how quickly, the benchmark tells
    assert answered - asked > STREAM
    for residual, following in pairwise(bench.residuals):
        assert following.sequence == (residual.sequence + 1 if following.run == residual.run else 0)
    assert all(health.missing == 0 for health in bench.health)

    before = bench.whole_run(run)
    added = bench.answer(bench.ask(Apply, "/monitor/apply"))
    assert added.success and diagnosis.verdict in added.message
    after = bench.whole_run(bench.run_of_twin() + 1)  # the first that the changed twin answers from its beginning
    for signal in ("current", "output_position"):
        excess = [
            getattr(health.rmse, signal) ** 2 - getattr(health.noise_floor, signal) ** 2 for health in (before, after)
        ]
        assert excess[1] < GONE * excess[0], signal

    # what else a window shows depends on where it ends; what was added is in none of them missing
    assert not effects_found(bench.diagnosed_at_rest()) & effects_found(diagnosis)


@pytest.mark.slow
@pytest.mark.parametrize("bench", [own], indirect=True)
def test_what_the_services_refuse_and_that_one_may_go_back(bench):
    refused = bench.answer(bench.ask(Apply, "/monitor/apply"))
    assert not refused.success and "nothing was diagnosed yet" in refused.message
    bench.compared(100)
    refused = bench.answer(bench.ask(Diagnose, "/monitor/diagnose", window=-1.0))
    assert not refused.success and "window -1" in refused.message
    refused = bench.answer(bench.ask(Diagnose, "/monitor/diagnose", window=0.05))
    assert not refused.success and "longer" in refused.message
    bench.compared(4500)
    bench.diagnosed_at_rest()
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
    assert "backlash" in {entry.id for entry in bench.diagnosed_at_rest().ranking if entry.found}

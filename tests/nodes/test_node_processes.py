"""Each node as a process of its own, as `ros2 run` starts it: clean ends, clear refusals, nothing lost between them."""

import re
import signal
import threading
from importlib import import_module

import pytest
from rclpy.duration import Duration
from ros_graph import ended_well, figures

from ema_bench_replay.bags.bag_reader import read_bag
from ema_bench_replay.load import load
from ema_bench_replay.nodes import qos
from ema_bench_replay.nodes.sample_codec import write_state
from ema_twin_msgs.msg import EmaState
from ema_twin_sim.comparison.compare import compare
from ema_twin_sim.model import load_model
from ema_twin_sim.nodes.live import run_live
from ema_twin_sim.nodes.monitor import MonitorNode
from tests.command_line import ENDING

REPLAY, RECORD = "ema_bench_replay.nodes.replay", "ema_bench_replay.nodes.record"
TWIN, MONITOR = "ema_twin_sim.nodes.twin", "ema_twin_sim.nodes.monitor"
ALL = Duration(seconds=60.0)
"""In which a reader must have received all that was published, on a busy machine too."""


@pytest.fixture(scope="module")
def trace(traces):
    return next(path for path in traces if "sine_0.02" in path.name)


def wait_for_nodes(graph, *names):
    tester = graph.plain_node()
    graph.spin_until(lambda: set(names) <= set(tester.get_node_names()))


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=lambda number: number.name)
def test_a_signal_ends_every_node_with_status_0(graph, start, trace, tmp_path, number):
    nodes = {
        "twin": start(TWIN),
        "monitor": start(MONITOR),
        "record": start(RECORD, f"output:={tmp_path / 'bag'}"),
        "replay": start(REPLAY, f"recording:={trace}", "loop:=true", "subscribers:=3", "patience:=60.0"),
    }
    wait_for_nodes(graph, *nodes)
    monitor = graph.add(MonitorNode)
    graph.spin_until(lambda: monitor.pairing.compared > 100)
    for process in nodes.values():
        process.send_signal(number)
    outputs = {name: process.communicate(timeout=ENDING)[1] for name, process in nodes.items()}
    incomplete = nodes["record"].returncode == 1 and "; lost: " in outputs["record"]
    well = {name for name, errors in outputs.items() if ended_well(nodes[name], errors)}
    assert nodes.keys() - well <= ({"record"} if incomplete else set()), outputs
    assert "Traceback" not in "".join(outputs.values())
    assert "FATAL" not in "".join(outputs.values())
    assert "stopped after" in outputs["replay"]
    said = {"twin": "answers every sample", "monitor": "compares", "record": "writes", "replay": f"plays {trace.stem}"}
    assert all(words in outputs[name] for name, words in said.items())  # that it is well
    # health keeps one message only, and a busy machine may let it pass; of the samples none may be lost
    lost = outputs["record"].partition("lost: ")[2]
    assert "messages of" in outputs["record"] and "/state" not in lost and "/residual" not in lost
    assert len(read_bag(tmp_path / "bag")) > 100
    assert (tmp_path / "bag" / "metadata.yaml").is_file()


@pytest.mark.slow
def test_nothing_is_lost_between_processes_as_fast_as_they_go(graph, start, trace, tmp_path):
    """The whole recording, unpaced: a monitor here, the others in processes, and a recorder beside them."""
    monitor = graph.add(MonitorNode)
    told = graph.diagnostics(graph.plain_node("listener"))
    twin, record = start(TWIN), start(RECORD, f"output:={tmp_path / 'bag'}")
    wait_for_nodes(graph, "twin", "record")
    replay = start(REPLAY, f"recording:={trace}", "rate:=0", "subscribers:=3", "patience:=60.0")
    graph.spin_until(lambda: monitor.complete and replay.poll() is not None)
    recording = load(trace)
    assert replay.returncode == 0
    assert f"sent {len(recording)} samples" in replay.communicate()[1]
    all_of_it = dict.fromkeys(("/bench/state", "/twin/state"), f"{len(recording)} messages written")
    graph.spin_until(lambda: "record" in told and all_of_it.items() <= figures(told["record"]).items())
    for process in (record, twin):
        process.send_signal(signal.SIGINT)
    assert twin.wait(ENDING) == 0
    # what is published to be seen and not to be kept, as joint states, may pass a busy recorder by: it tells which
    lost = record.communicate(timeout=ENDING)[1].partition("; lost: ")[2]
    assert "/state" not in lost and (lost or record.returncode == 0)
    offline = compare([recording], load_model("polito_bench")).recordings[0].signals
    for name, live in monitor.comparison.result().items():
        assert live["rmse"] == pytest.approx(offline[name]["rmse"], rel=1e-6), name
    for topic in all_of_it:
        assert len(read_bag(tmp_path / "bag", topic=topic)) == len(recording)


@pytest.mark.slow
def test_what_the_recorder_loses_it_counts(graph, start, tmp_path):
    """A publisher that keeps ten messages does not wait for a recorder that stands still."""
    record = start(RECORD, f"output:={tmp_path / 'bag'}", "topics:=[/lo*]")
    publisher = graph.plain_node().create_publisher(EmaState, "/loud", qos.JOINT_STATES)
    graph.spin_until(publisher.get_subscription_count)
    publisher.publish(write_state(1, 1, 0, {"current": 1.0}))
    assert publisher.wait_for_all_acked(ALL)
    record.send_signal(signal.SIGSTOP)
    for sequence in range(1, 5000):
        publisher.publish(write_state(sequence + 1, 1, sequence, {"current": 1.0}))
    record.send_signal(signal.SIGCONT)
    for sequence in range(5000, 5020):
        publisher.publish(write_state(sequence + 1, 1, sequence, {"current": 1.0}))
        graph.spin_for(0.05)
    assert publisher.wait_for_all_acked(ALL)
    graph.spin_for(0.3)
    record.send_signal(signal.SIGINT)
    error = record.communicate(timeout=ENDING)[1]
    assert record.returncode == 1
    written, lost = map(int, re.search(r"(\d+) messages of 1 topics.*lost: (\d+) of /loud", error).groups())
    assert lost > 1000
    assert written + lost == 5020
    assert len(read_bag(tmp_path / "bag")) == written


def test_live_attaches_to_a_bench_that_is_running(start, trace):
    start(REPLAY, f"recording:={trace}", "subscribers:=0", "loop:=true")
    pairs, stop = [], threading.Event()

    def take(batch):
        pairs.extend(batch)
        if len(pairs) > 500:
            stop.set()

    live = run_live(None, load_model("polito_bench"), on_pairs=take, stop=stop)
    assert live.complete
    assert live.counts["missing"] == 0
    assert live.samples >= 500
    assert live.name == trace.stem


REFUSED = {
    TWIN: [
        (["model:=polito_bnech"], ["polito_bnech", "polito_bench"]),
        (["input:=voltage"], ["twin: parameter input", "one of auto, setpoint, current, standalone"]),
        (["effects.backlash.width:=-1.0"], ["effects.backlash.width", "0 to"]),
        (["effects.backlash.widht:=0.1"], ["effects.backlash.widht", "did you mean 'effects.backlash.width'"]),
        (["input:=standalone", "command:=ramp"], ["command 'ramp'", "rad/s"]),
    ],
    MONITOR: [(["window:=wide"], ["monitor: parameter window", "a number", "0.01 to 60 s"])],
    REPLAY: [
        ([], ["replay: parameter recording", "give recording:=FILE"]),
        (["recording:=none.mcap"], ["none.mcap", "no such file"]),
        (["recording:=TRACE", "start:=30.0"], ["30 s is not within the recording"]),
        (["recording:=TRACE", "rate:=-1.0"], ["replay: parameter rate", "0 to 1000"]),
    ],
    RECORD: [
        ([], ["record: parameter output", "give output:=FOLDER"]),
        (["output:=/proc/bag"], ["/proc/bag", "cannot be written"]),
    ],
}
"""Of each node: parameters, and what the one line must hold."""


def is_one_line(error, expected):
    lines = error.strip().splitlines()
    assert len(lines) == 1, error
    for part in expected:
        assert part in lines[0]


@pytest.mark.parametrize(
    ("module", "parameters", "expected"), [(module, *case) for module, cases in REFUSED.items() for case in cases]
)
def test_what_a_node_cannot_do_is_one_line_and_status_2(trace, module, parameters, expected, monkeypatch, capfd):
    """By what its process runs, in this one."""
    given = [word for parameter in parameters for word in ("-p", parameter.replace("TRACE", str(trace)))]
    monkeypatch.setattr("sys.argv", [module, "--ros-args", *given])
    assert import_module(module).main() == 2
    is_one_line(capfd.readouterr().err, expected)


@pytest.mark.slow
def test_so_does_each_as_a_process(start):
    refused = {module: (start(module, *cases[0][0]), cases[0][1]) for module, cases in REFUSED.items()}
    for process, expected in refused.values():
        error = process.communicate(timeout=ENDING)[1]
        assert process.returncode == 2
        is_one_line(error, expected)

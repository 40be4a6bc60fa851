"""The recorder's own process: what it says of a full disk and of a removed file, how it ends, and what a kill costs."""

import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.qos import QoSProfile
from ros_graph import figures

from ema_bench_replay.errors import InputError
from ema_bench_replay.load import load
from ema_bench_replay.nodes import diagnostics
from ema_bench_replay.nodes.record import RecordNode
from ema_bench_replay.nodes.sample_codec import write_state
from ema_twin_msgs.msg import EmaState
from tests.command_line import ENDING, MODEL, done_here
from tests.namespaces import on_own_disk

RECORD = "ema_bench_replay.nodes.record"
TOPIC = "/bench/state"


class Bench:
    """Publishes samples, and hears what the recorder says on /diagnostics."""

    def __init__(self, graph):
        self.graph = graph
        node = graph.plain_node()
        self.publisher = node.create_publisher(EmaState, TOPIC, QoSProfile(depth=5000))
        self.sent = 0
        self.told = graph.diagnostics(node)

    def send_until(self, condition, what):
        """Publish some 500 samples a second until that is so."""
        deadline = time.monotonic() + 60.0
        while not condition():
            assert time.monotonic() < deadline, f"waited 60 s in vain for {what}"
            self.publisher.publish(write_state(time.time_ns(), 1, self.sent, {"current": float(self.sent % 97)}))
            self.sent += 1
            self.graph.executor.spin_once(timeout_sec=0.002)

    def send(self, count):
        until = self.sent + count
        self.send_until(lambda: self.sent >= until, "the samples")

    @property
    def status(self):
        return self.told.get("record", DiagnosticStatus())

    @property
    def figures(self):
        return figures(self.status)

    def await_recorder(self):
        self.graph.spin_until(self.publisher.get_subscription_count, what="the recorder")


@pytest.fixture
def bench(graph):
    return Bench(graph)


@pytest.fixture
def recorder(start):
    return lambda *parameters: start(RECORD, f"topics:=[{TOPIC}]", *parameters)


def ended(record):
    """(status, last line) of a recorder that is told to end."""
    record.send_signal(signal.SIGINT)
    errors = record.communicate(timeout=ENDING)[1]
    return record.returncode, errors.strip().splitlines()[-1]


def test_what_comes_by_best_effort_may_be_missed_and_is_told(bench, tmp_path):
    """A clock that is sent fifty times a second misses some on a busy machine: that is no error of the recording."""
    recorder = bench.graph.add(RecordNode, output=str(tmp_path / "bag"), topics=["/nothing"])
    recorder.missed |= {"/clock": 6, "/bench/state": 0}
    recorder._best_effort.add("/clock")
    recorder._writer.add_topic("/clock", "rosgraph_msgs/msg/Clock", "")
    recorder._writer.add_topic("/bench/state", "ema_twin_msgs/msg/EmaState", "")
    report = recorder._report()
    assert (report.level, report.message) == (diagnostics.WARN, "6 messages are lost: 6 of /clock did not come")
    recorder.missed["/bench/state"] = 1
    assert recorder._report().level == diagnostics.ERROR
    assert "6 of /clock, 1 of /bench/state did not come" in recorder._report().message
    recorder.missed["/bench/state"] = 0
    recorder.close()
    assert recorder.exit_status == 0


@pytest.mark.slow
@pytest.mark.parametrize("what", ["file", "folder"])
def test_a_file_that_is_removed_is_told_and_gone_on_from(bench, recorder, tmp_path, what):
    folder = tmp_path / "bag"
    record = recorder(f"output:={folder}")
    bench.await_recorder()
    bench.send_until(lambda: int(bench.figures.get(TOPIC, "0").split()[0]) > 300, "300 messages on disk")
    assert bench.status.level == DiagnosticStatus.OK
    shutil.rmtree(folder) if what == "folder" else (folder / "bag.mcap").unlink()
    bench.send_until(lambda: bench.status.level == DiagnosticStatus.ERROR, "an error on /diagnostics")
    lost = int(bench.figures["messages lost"])
    assert lost > 300
    assert bench.status.message.endswith(f"{lost} were in {folder / 'bag.mcap'}, which was removed or moved")
    bench.send(200)
    bench.graph.spin_for(0.5)
    status, last = ended(record)
    assert status == 1
    assert f"{bench.sent - lost} messages of 1 topics in {folder / 'bag_1.mcap'}; lost: {lost} of {TOPIC}" in last
    assert "none lost" not in last
    assert len(load(folder)) == bench.sent - lost


@pytest.mark.slow
def test_nothing_is_lost_between_files(bench, recorder, tmp_path):
    record = recorder(f"output:={tmp_path / 'bag'}", "max_bagfile_duration:=0.5")
    bench.await_recorder()
    bench.send(1500)
    bench.graph.spin_for(0.5)
    status, last = ended(record)
    files = sorted(path.name for path in (tmp_path / "bag").glob("*.mcap"))
    assert status == 0 and len(files) > 4
    assert last.endswith(
        f"1500 messages of 1 topics in {tmp_path / 'bag' / 'bag.mcap'} and {len(files) - 1} more, none lost"
    )
    recording = load(tmp_path / "bag")
    assert len(recording) == 1500 and not recording.warnings


@pytest.mark.slow
def test_a_full_disk_is_told_and_gone_on_from(bench, tmp_path):
    """A file system of its own, in a namespace where the user may mount one; a file in it takes the room."""
    disk = tmp_path / "disk"
    disk.mkdir()
    folder, kept = disk / "bag", tmp_path / "kept"
    node = f"-m {RECORD} --ros-args -p output:={folder} -p topics:=[{TOPIC}]"
    script = f"trap : INT && {sys.executable} {node}; status=$?; cp -r {folder} {kept}; exit $status"
    command = on_own_disk(disk, "1000k", script)
    record = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, start_new_session=True)
    try:
        bench.await_recorder()
        seen = Path(f"/proc/{record.pid}/root{disk}")  # the disk, from out here
        (seen / "other").write_bytes(bytes(900_000))
        bench.send_until(lambda: bench.status.level == DiagnosticStatus.ERROR, "an error on /diagnostics")
        assert "No space left on device" in bench.status.message and "make room" in bench.status.message
        bench.send_until(lambda: int(bench.figures["messages waiting"]) > 100, "messages that wait")
        (seen / "other").unlink()
        bench.send_until(lambda: bench.status.level == DiagnosticStatus.OK, "room that is used")
        bench.graph.spin_for(0.5)
        pids = Path(f"/proc/{record.pid}/task/{record.pid}/children").read_text().split()
        for pid in pids:
            subprocess.run(["kill", "-INT", pid], check=True)
        errors = record.communicate(timeout=ENDING)[1]
    finally:
        record.kill()
        record.communicate()
    assert record.returncode == 0, errors
    assert f"{bench.sent} messages of 1 topics" in errors and "none lost" in errors
    recording = load(kept)
    assert len(recording) == bench.sent and not recording.warnings


@pytest.mark.slow
def test_a_kill_costs_a_quarter_of_a_second_at_most(bench, recorder, tmp_path):
    """`tests.benchmarks.bench_recorder` does it a hundred times, beside all nodes."""
    for k in range(5):
        folder = tmp_path / f"bag_{k}"
        file = folder / f"{folder.name}.mcap"
        record = recorder(f"output:={folder}")
        bench.send_until(lambda file=file: file.exists() and file.stat().st_size > 5000, "messages on disk")
        bench.send(300 + 37 * k)
        killed = time.time_ns()
        record.kill()
        record.communicate()
        kept = load(folder)
        assert killed - (kept.start + kept.stamps[-1]) < 0.25e9


@pytest.mark.slow
def test_a_live_run_that_is_not_recorded_whole_is_refused(ramp, tmp_path, monkeypatch):
    """Its errors are told all the same."""
    from ema_twin_sim.nodes import live

    folder = tmp_path / "bag"
    run_live = live.run_live

    def removing(*arguments, on_pairs, **options):
        def take(pairs):
            on_pairs(pairs)
            if (folder / "bag_1.mcap").exists():
                (folder / "bag.mcap").unlink(missing_ok=True)

        return run_live(*arguments, on_pairs=take, **options)

    monkeypatch.setattr(live, "run_live", removing)
    figures = tmp_path / "live.json"
    arguments = ("live", ramp, *MODEL, "--headless", "--to", "3", "--record", folder, "--json", figures)
    with pytest.raises(InputError, match=r"bag: the recording is incomplete: lost: \d+ of /\w.* was removed or moved"):
        done_here(*arguments, "--max-bag-duration", "1")
    assert figures.exists()
    assert len(list(folder.glob("bag_*.mcap"))) > 1
    monkeypatch.undo()
    with pytest.raises(InputError, match="give --record DIR"):
        done_here("live", ramp, *MODEL, "--headless", "--max-bag-size", "1e6")
    done_here(*arguments[:-3], folder, "--force", "--max-bag-size", "100000")
    assert len(load(folder)) == len(load(ramp).between(None, 3.0))

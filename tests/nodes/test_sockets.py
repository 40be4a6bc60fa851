"""Every process that the product starts has its sockets on loopback, and no other: nodes, `live`, its view, a campaign.

As somebody starts them who has chosen nothing. What a node shares by memory would be another door: there is none.
"""

import os
import shutil
import socket
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from ros_graph import start_process

from tests.command_line import ENDING, MODEL, TWIN
from tests.conftest import RECORDINGS
from tests.sockets import family, sockets, sockets_during

LOOKED_AT = 2.0
"""s: Fast DDS binds what it sends from with the first reader of each writer, and announces itself every second."""
SINE = next(RECORDINGS.glob("*sine_0.05*"))


@pytest.fixture
def started(nothing_chosen):
    """Keeps processes that were started by somebody who has chosen nothing; what they say goes into lists of lines."""
    processes = []

    def keep(process, stream):
        lines, spoke = [], threading.Condition()

        def read():
            for line in stream:
                with spoke:
                    lines.append(line)
                    spoke.notify_all()

        threading.Thread(target=read, daemon=True).start()
        processes.append(process)

        def said(words):
            with spoke:
                assert spoke.wait_for(lambda: words in "".join(lines), ENDING), lines
            return process.pid

        return said

    yield keep
    for process in processes:
        process.terminate()
    for process in processes:
        try:
            process.wait(ENDING)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def node(started, module, *parameters):
    process = start_process(module, *parameters)
    return started(process, process.stderr)


def command(started, *arguments):
    """The command line, with what it says and what its nodes log."""
    process = subprocess.Popen(
        [TWIN, *map(str, arguments)],
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip
    return started(process, process.stdout)


def is_kept_to_this_machine(process, kinds, seconds=LOOKED_AT):
    """All its sockets are on loopback, all of these kinds are among them, and it shares no memory with other nodes."""
    found = sockets_during(process, seconds)
    assert {one.kind for one in found} >= set(kinds), found
    assert {one for one in found if not one.loopback} == set()
    for one in family(process):
        assert "/dev/shm/fastrtps" not in Path(f"/proc/{one.pid}/maps").read_text()


NODES = {
    "twin": ("ema_twin_sim.nodes.twin", "input:=standalone", "runs"),
    "monitor": ("ema_twin_sim.nodes.monitor", "window:=2.0", "compares"),
    "record": ("ema_bench_replay.nodes.record", "output:=bag", "writes"),
    "replay": ("ema_bench_replay.nodes.replay", f"recording:={SINE}", "plays"),
}
"""Module, a parameter, and what it says when it runs."""


@pytest.mark.parametrize("name", NODES)
def test_a_node(name, started):
    module, parameter, runs = NODES[name]
    is_kept_to_this_machine(node(started, module, parameter)(runs), {"udp"}, 0.5)


@pytest.mark.slow
def test_the_four_nodes_as_they_work_together(started, tmp_path):
    """What a node sends to others goes out from sockets that it had no need of alone."""
    bench = f"recording:={SINE}", "loop:=true", "subscribers:=3", "patience:=60.0"
    parameters = {"twin": ["input:=auto"], "monitor": [], "record": ["output:=bag"], "replay": bench}
    nodes = {name: node(started, NODES[name][0], *parameters[name]) for name in NODES}
    for name, said in nodes.items():
        said(NODES[name][2] if name != "twin" else "answers")
    with ThreadPoolExecutor() as together:
        [*together.map(lambda said: is_kept_to_this_machine(said(""), {"udp"}), nodes.values())]
    assert list((tmp_path / "bag").glob("*.mcap"))


@pytest.mark.slow
def test_live(started, tmp_path):
    said = command(started, "live", SINE, *MODEL, "--headless", "--loop", "--record", tmp_path / "live")
    is_kept_to_this_machine(said("1.0 of"), {"udp"})


@pytest.mark.slow
def test_live_with_its_view_in_a_browser(started):
    """Two servers of ours and rerun's, and rerun's viewer that is fed by a connection."""
    process = command(started, "live", SINE, *MODEL, "--web", "--loop")("1.0 of")
    assert {one.name() for one in family(process)} > {"rerun"}
    is_kept_to_this_machine(process, {"udp", "listening", "tcp"})
    assert {one.process for one in sockets(process) if one.kind == "listening"} > {"rerun"}


@pytest.mark.slow
def test_a_campaign_with_workers_of_its_own(started, tmp_path):
    """A scheduler and workers, from the campaign's first moment to its end."""
    for k in range(6):
        shutil.copy(SINE, tmp_path / f"run_{k}.CSV")
    process = subprocess.Popen(
        [TWIN, "campaign", tmp_path, "-o", tmp_path / "results", "--do", "compare", *MODEL, "--workers", "2"],
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip
    started(process, process.stdout)
    found = sockets_during(process.pid, 120.0, over=lambda: process.poll() is not None)
    assert process.returncode == 0
    assert len({one.port for one in found if one.kind == "listening"}) >= 3  # the scheduler's, and two workers'
    assert {one for one in found if not one.loopback} == set()


@pytest.mark.parametrize(("kind", "name"), [(socket.SOCK_DGRAM, "udp"), (socket.SOCK_STREAM, "listening")])
def test_a_socket_that_is_open_to_others_would_be_noticed(kind, name):
    """Of a process that another one started, too."""
    bound = f"import socket, time; s = socket.socket(socket.AF_INET, {int(kind)}); s.bind(('0.0.0.0', 0)); "
    told = "s.type == socket.SOCK_STREAM and s.listen(); print(s.getsockname()[1], flush=True); time.sleep(600)"
    shell = subprocess.Popen(
        ["sh", "-c", '"$0" -c "$1"; true', sys.executable, bound + told],
        stdout=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip
    try:
        port = int(shell.stdout.readline())
        (found,) = sockets(shell.pid)
        assert (found.kind, found.address, found.port, found.loopback) == (name, "0.0.0.0", port, False)
    finally:
        os.killpg(shell.pid, 9)
        shell.wait()

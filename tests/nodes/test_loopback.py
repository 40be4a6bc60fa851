"""The nodes are heard on this machine alone, unless ROS's own variable opens them to the network."""

import subprocess
import sys
import time
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
from ros_graph import start_process

from ema_bench_replay.nodes import loopback
from ema_bench_replay.nodes.loopback import LOOPBACK, PROFILES, RANGE, keep_to_this_machine

EPHEMERAL = int(Path("/proc/sys/net/ipv4/ip_local_port_range").read_text().split()[0])
"""Ports from here on belong to sockets that only send."""
LOOPBACK_ADDRESS = "0100007F"  # 127.0.0.1 as the kernel has it


def test_a_range_that_was_chosen_stays():
    environment = {RANGE: "SUBNET"}
    keep_to_this_machine(environment)
    assert environment == {RANGE: "SUBNET"}


def test_transports_that_were_chosen_stay():
    environment = {PROFILES[1]: "/etc/own.xml"}
    keep_to_this_machine(environment)
    assert environment == {RANGE: "LOCALHOST", PROFILES[1]: "/etc/own.xml"}


def test_the_profile_is_taken_where_nothing_was_chosen():
    environment = {}
    keep_to_this_machine(environment)
    assert environment == {RANGE: "SYSTEM_DEFAULT", **dict.fromkeys(PROFILES, str(LOOPBACK))}


def test_another_middleware_keeps_to_this_machine_by_the_range(monkeypatch):
    monkeypatch.setattr(loopback, "get_rmw_implementation_identifier", lambda: "rmw_cyclonedds_cpp")
    environment = {}
    keep_to_this_machine(environment)
    assert environment == {RANGE: "LOCALHOST"}


def test_the_profile_names_no_other_address():
    addresses = {e.text for e in ElementTree.parse(LOOPBACK).iter() if e.tag.endswith("}address")}
    assert addresses == {"127.0.0.1"}


@pytest.fixture
def start(monkeypatch, tmp_path):
    """Starts nodes as somebody who has chosen nothing would."""
    for name in (RANGE, *PROFILES):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.chdir(tmp_path)
    processes = []

    def start(module, *parameters):
        processes.append(start_process(module, *parameters))
        return processes[-1]

    yield start
    for process in processes:
        process.kill()
        process.communicate()


def listening(process):
    """The addresses (hexadecimal, as the kernel has them) on which a process waits for datagrams or connections."""
    held = set()
    for descriptor in Path(f"/proc/{process}/fd").iterdir():
        try:
            held.add(str(descriptor.readlink()))
        except OSError:  # closed meanwhile
            continue
    found = []
    for kind in ("udp", "udp6", "tcp", "tcp6"):
        for line in Path(f"/proc/net/{kind}").read_text().splitlines()[1:]:
            cells = line.split()
            address, port = cells[1].split(":")
            if f"socket:[{cells[9]}]" in held and int(port, 16) < EPHEMERAL:
                found.append(address)
    return found


@pytest.mark.parametrize(
    ("module", "parameter"),
    [
        ("ema_bench_replay.nodes.record", "output:=bag.mcap"),
        ("ema_twin_sim.nodes.twin", "input:=standalone"),
        ("ema_twin_sim.nodes.monitor", "services:=false"),
    ],
)
def test_a_node_listens_on_loopback_alone(module, parameter, start):
    process = start(module, parameter)
    until = time.monotonic() + 60.0
    while not listening(process.pid) and time.monotonic() < until:
        assert process.poll() is None, process.communicate()
        time.sleep(0.1)
    time.sleep(0.5)  # the last of its sockets
    assert {*listening(process.pid)} == {LOOPBACK_ADDRESS}
    assert "/dev/shm/fastrtps" not in Path(f"/proc/{process.pid}/maps").read_text()


PLAIN_NODE = """
import rclpy
from ema_twin_msgs.msg import EmaState
rclpy.init()
heard = []
node = rclpy.create_node("plain")
node.create_subscription(EmaState, "/twin/state", heard.append, rclpy.qos.qos_profile_sensor_data)
while not heard:
    rclpy.spin_once(node)
"""


def test_a_plain_node_of_this_machine_hears_it(start):
    """ROS's own tools look for nodes in the whole network, this machine in it."""
    start("ema_twin_sim.nodes.twin", "input:=standalone")
    subprocess.run([sys.executable, "-c", PLAIN_NODE], check=True, timeout=60.0)

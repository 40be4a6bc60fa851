"""The nodes are heard on this machine alone, unless ROS's own variable opens them to the network."""

import subprocess
import sys
import xml.etree.ElementTree as ElementTree

import pytest
from ros_graph import start_process

from ema_bench_replay.nodes import loopback
from ema_bench_replay.nodes.loopback import LOOPBACK, PROFILES, RANGE, keep_to_this_machine


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

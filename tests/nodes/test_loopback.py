"""The nodes are heard on this machine alone, unless ROS's own variable opens them to the network."""

import json
import os
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

import pytest

from ema_bench_replay.nodes import loopback
from ema_bench_replay.nodes.loopback import LOOPBACK, PROFILES, RANGE, keep_to_this_machine
from tests.namespaces import ALONE, needs_own_network


@pytest.mark.parametrize(
    ("chosen", "added"),
    [
        ({RANGE: "SUBNET"}, {}),
        ({PROFILES[1]: "/etc/own.xml"}, {RANGE: "LOCALHOST"}),
        ({}, {RANGE: "SYSTEM_DEFAULT", **dict.fromkeys(PROFILES, str(LOOPBACK))}),
    ],
    ids=["a range", "transports", "nothing"],
)
def test_what_was_chosen_stays_and_the_profile_is_taken_where_nothing_was(chosen, added):
    environment = dict(chosen)
    keep_to_this_machine(environment)
    assert environment == {**chosen, **added}


def test_another_middleware_keeps_to_this_machine_by_the_range(monkeypatch):
    monkeypatch.setattr(loopback, "get_rmw_implementation_identifier", lambda: "rmw_cyclonedds_cpp")
    environment = {}
    keep_to_this_machine(environment)
    assert environment == {RANGE: "LOCALHOST"}


def test_the_profile_names_no_other_address():
    addresses = {e.text for e in ElementTree.parse(LOOPBACK).iter() if e.tag.endswith("}address")}
    assert addresses == {"127.0.0.1"}


WITH_A_PROFILE = """
import json
import os
import signal
import sys
from pathlib import Path

from ema_bench_replay.errors import InputError
from ema_bench_replay.nodes import loopback
from ema_twin_sim.model import load_model
from ema_twin_sim.nodes import monitor
from ema_twin_sim.nodes.live import run_live

def become(what):
    if what == "node":
        sys.exit(monitor.main())
    try:
        run_live(None, load_model("polito_bench"), on_start=lambda node: sys.exit(0))
    except InputError as error:
        print(error, file=sys.stderr)
        sys.exit(2)

for order in sys.stdin:
    profile, what = json.loads(order)
    ours, theirs = os.pipe()
    child = os.fork()
    if not child:
        os.dup2(theirs, 2)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # where answers are given, Fast DDS writes too
        os.close(ours)
        loopback.LOOPBACK = Path(profile)
        become(what)
        sys.exit()
    os.close(theirs)
    said = []
    with os.fdopen(ours) as stream:
        for line in stream:
            said.append(line)
            if "compares" in line:
                os.kill(child, signal.SIGTERM)
    print(json.dumps([os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), said]), flush=True)
"""
"""Gives each order to a child of its own: libraries are read once."""


@pytest.fixture(scope="class")
def started_with():
    """What the monitor, or a live run, does with a profile in the place of ours."""
    process = subprocess.Popen(
        [*ALONE, sys.executable, "-c", WITH_A_PROFILE], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        env={name: value for name, value in os.environ.items() if name not in (RANGE, *PROFILES)},
    )  # fmt: skip

    def order(profile, what):
        print(json.dumps([str(profile), what]), file=process.stdin, flush=True)
        return json.loads(process.stdout.readline())

    yield order
    process.communicate()


@needs_own_network
@pytest.mark.slow
class TestProfileThatIsNotTaken:
    """Fast DDS goes on with sockets on every address. A node that finds them ends before it serves anybody."""

    @pytest.mark.parametrize("what", ["node", "live"])
    def test_ours_is_taken(self, what, started_with):
        status, said = started_with(LOOPBACK, what)
        assert status == 0, said

    @pytest.mark.parametrize("what", ["node", "live"])
    def test_one_that_is_not_there(self, what, started_with, tmp_path):
        self.is_refused(tmp_path / "none.xml", *started_with(tmp_path / "none.xml", what))

    @pytest.mark.parametrize(
        "part",
        ["intraprocess", "interfaceWhiteList", "leaseDuration", "heartbeatPeriod", "max_samples", "</profiles>"],
    )
    def test_a_fault_in_any_line(self, part, started_with, tmp_path):
        assert part in LOOPBACK.read_text()
        (tmp_path / "faulty.xml").write_text(LOOPBACK.read_text().replace(part, part.swapcase()))
        self.is_refused(tmp_path / "faulty.xml", *started_with(tmp_path / "faulty.xml", "node"))

    def is_refused(self, profile, status, said):
        (line,) = (line for line in said if "XMLPARSER" not in line)
        assert status == 2 and str(profile) in line and "make setup" in line and RANGE in line


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


@pytest.mark.slow
@pytest.mark.usefixtures("nothing_chosen")
def test_a_plain_node_of_this_machine_hears_it(start):
    """ROS's own tools look for nodes in the whole network, this machine in it."""
    start("ema_twin_sim.nodes.twin", "input:=standalone")
    subprocess.run([sys.executable, "-c", PLAIN_NODE], check=True, timeout=60.0)

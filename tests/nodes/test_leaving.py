"""A node's process ends, whatever the middleware does as it leaves."""

import subprocess
import sys

from ros_graph import Graph

from ema_bench_replay.nodes import spin
from tests.command_line import ENDING

BLOCKED = """
import ctypes, sys
from ema_bench_replay.nodes import spin

class Blocked:
    def close(self):
        print("closed", flush=True)
    def destroy_node(self):
        ctypes.PyDLL(None).sleep(600)  # no thread of Python runs meanwhile, as within rclpy

spin._LONGEST_LEAVING = 0.2
spin.leave_graph([Blocked()])
"""


def test_a_process_that_the_middleware_holds_ends_by_force_once_what_is_its_own_is_closed():
    ended = subprocess.run([sys.executable, "-c", BLOCKED], capture_output=True, text=True, timeout=ENDING, check=False)
    assert ended.returncode == 1
    assert ended.stdout == "closed\n"
    assert "Timeout" in ended.stderr
    assert "destroy_node" in ended.stderr


def test_nothing_ends_by_force_once_all_nodes_have_left(monkeypatch):
    graph = Graph()
    node = graph.plain_node()
    graph.executor.shutdown()
    cancelled = []
    monkeypatch.setattr(spin.faulthandler, "cancel_dump_traceback_later", lambda: cancelled.append(graph.context.ok()))
    monkeypatch.setattr(spin.faulthandler, "dump_traceback_later", lambda *_, **__: None)
    spin.leave_graph([node], graph.context)
    assert cancelled == [False]

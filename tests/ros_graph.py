"""What the ROS tests share: nodes in this process on a graph of their own, and nodes as processes."""

import inspect
import os
import subprocess
import sys
import time
from contextlib import contextmanager

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.context import Context
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions

from ema_bench_replay.nodes import qos
from ema_bench_replay.nodes.spin import make_executor


class Graph:
    """Nodes of one test, served by one executor in the test's own thread."""

    def __init__(self):
        self.context = Context()
        rclpy.init(args=[], context=self.context, signal_handler_options=SignalHandlerOptions.NO)
        self.executor = make_executor([], self.context)
        self.nodes = []

    def add(self, node_class, *arguments, **parameters):
        """A node of that class with these parameters."""
        given = [Parameter(name, value=value) for name, value in parameters.items()]
        return self.join(node_class(*arguments, parameters=given, context=self.context))

    def join(self, node):
        self.nodes.append(node)
        self.executor.add_node(node)
        return node

    def plain_node(self, name="tester"):
        return self.join(rclpy.create_node(name, context=self.context))

    def spin_until(self, condition, timeout=60.0, what=""):
        """Serve the nodes until the condition holds; where it never does, tell `what` was waited for, or its source."""
        end = time.monotonic() + timeout
        while not condition():
            assert time.monotonic() < end, f"waited {timeout:g} s in vain for: {what or source_of(condition)}"
            self.executor.spin_once(timeout_sec=0.05)

    def spin_for(self, seconds):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.executor.spin_once(timeout_sec=0.01)

    def diagnostics(self, node):
        """The last status of each node by its name, as a node hears them: filled as the graph is served."""
        told = {}

        def keep(message):
            told.update((status.name.partition(":")[0], status) for status in message.status)

        node.create_subscription(DiagnosticArray, "/diagnostics", keep, qos.DIAGNOSTICS)
        return told

    def call(self, node, service_type, name, **request):
        """Call a service through a client of `node`."""
        client = node.create_client(service_type, name)
        assert client.wait_for_service(timeout_sec=30.0)
        future = client.call_async(service_type.Request(**request))
        self.spin_until(future.done, what=f"the answer of {name}")
        node.destroy_client(client)
        return future.result()

    def close(self):
        self.executor.shutdown()
        for node in self.nodes:
            node.destroy_node()
        rclpy.try_shutdown(context=self.context)


def figures(status):
    """The figures of a node's report, by their names."""
    return {value.key: value.value for value in status.values}


def source_of(condition):
    """The lines that a condition is written in; what is not written in Python stands for itself."""
    try:
        return inspect.getsource(condition).strip()
    except (OSError, TypeError):
        return repr(condition)


def start_process(module, *parameters, **options):
    """A node in a process of its own, as `ros2 run` starts it; `parameters` as NAME:=VALUE."""
    given = [word for parameter in parameters for word in ("-p", parameter)]
    command = [sys.executable, "-m", module, "--ros-args", *given]
    return subprocess.Popen(command, env=os.environ.copy(), stderr=subprocess.PIPE, text=True, **options)


@contextmanager
def starter():
    """What starts nodes as ``start_process`` does; those that a failed test leaves are ended."""
    processes = []

    def start(*arguments):
        processes.append(start_process(*arguments))
        return processes[-1]

    yield start
    for process in processes:
        if process.poll() is None:
            process.kill()
            process.communicate()


def ended_well(process, errors):
    """Whether a node's process ended by itself: with status 0, or where Fast DDS blocked as all left at once."""
    blocked = process.returncode == 1 and errors.count("Timeout (0:00:10)!") == 1 and "destroy" in errors
    return process.returncode == 0 or blocked

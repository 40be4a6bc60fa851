"""The loop that runs every node, alone in its process or together with others.

Do not use rclpy's own `spin`: with `EventsExecutor`, which takes less than half the processor time of the default
executor at our rates, it uses a full core and delivers nothing. `spin_once` in a loop works.
"""

from __future__ import annotations

import faulthandler
import signal
import sys
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import rclpy
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.executors import Executor, ExternalShutdownException
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.timer import Timer
from rclpy.utilities import remove_ros_args

from ema_bench_replay.errors import InputError

from .loopback import check_kept_to_this_machine, keep_to_this_machine
from .parameter_help import parameter_help
from .parameters import Declaration

try:
    from rclpy.experimental import EventsExecutor as _Executor
except ImportError:
    from rclpy.executors import SingleThreadedExecutor as _Executor

_TIMEOUT = 0.2
"""Longest time [s] between two checks whether the loop should end."""

_LONGEST_LEAVING = 10.0
"""Longest time [s] that the middleware may take to close a process's nodes."""

_interrupted = threading.Event()


def interrupted() -> bool:
    """Whether SIGINT or SIGTERM arrived: code that waits for another process must then give up."""
    return _interrupted.is_set()


@contextmanager
def signals_end_the_loop() -> Iterator[None]:
    """Let SIGINT and SIGTERM end `spin` between two callbacks, with ROS still running, so that nodes can close files.

    rclpy's own handlers would shut ROS down during a callback. Does nothing outside the main thread, since only that
    one receives signals.
    """
    _interrupted.clear()
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    numbers = signal.SIGINT, signal.SIGTERM
    before = [signal.signal(number, lambda *_: _interrupted.set()) for number in numbers]
    try:
        yield
    finally:
        for number, handler in zip(numbers, before, strict=True):
            signal.signal(number, handler)


def make_executor(nodes: Iterable[Node], context: Context | None = None) -> Executor:
    """An executor that holds `nodes`; `spin` runs it."""
    executor = _Executor(context=context)
    for node in nodes:
        executor.add_node(node)
    return executor


def spin(executor: Executor, until: Callable[[], bool], context: Context | None = None) -> None:
    """Serve the executor's nodes until `until()` is true, SIGINT or SIGTERM arrives, or the context is shut down."""
    try:
        while rclpy.ok(context=context) and not _interrupted.is_set() and not until():
            executor.spin_once(timeout_sec=_TIMEOUT)
    except ExternalShutdownException:
        pass


def all_received(nodes: Iterable[Node]) -> bool:
    """Whether every reliable reader of the nodes' topics has received everything published."""
    return all(publisher.wait_for_all_acked(Duration()) for node in nodes for publisher in node.publishers)


def steady_timer(node: Node, period: float, callback: Callable[[], object]) -> Timer:
    """A timer [s] on the monotonic clock: `/clock` stops while a replay is paused, and jumps when it seeks.

    Its periods are counted from its creation and do not drift. Never `reset` it: with `EventsExecutor` that leaves a
    second call pending, and a timer that does so in its callback soon blocks all subscriptions.
    """
    return node.create_timer(period, callback, clock=Clock(clock_type=ClockType.STEADY_TIME))


def leave_graph(nodes: Iterable[Node], context: Context | None = None) -> None:
    """Close the nodes, in this order, and then ROS.

    First each node's `close`, if it has one: it finishes the node's own resources, such as a file, and may take long.
    Fast DDS occasionally blocks for ever when several processes leave at once (Fast-DDS issue 6502), inside a call that
    Python code cannot end. After 10 s the process then ends, with status 1 and the place on standard error.
    """
    nodes = list(nodes)
    for node in nodes:
        getattr(node, "close", lambda: None)()
    faulthandler.dump_traceback_later(_LONGEST_LEAVING, exit=True)
    try:
        for node in nodes:
            node.destroy_node()
        rclpy.try_shutdown(context=context)
    finally:
        faulthandler.cancel_dump_traceback_later()


def run(
    make_node: Callable[[], Node], parameters: Sequence[Declaration] = (), arguments: Sequence[str] | None = None
) -> int:
    """Run one node in this process until it says `finished`, or SIGINT or SIGTERM arrives.

    It logs the node's `ready_words`, if any, when it runs.

    `arguments` replace the process's own command line, including the program name. If the node has `parameters`,
    `--help` prints them.

    Returns:
        The process's exit status: the node's `exit_status`, 0 if it has none, or 2 if it refused its arguments, with
        one line on standard error.
    """
    words = list(sys.argv if arguments is None else arguments)
    if parameters and {"-h", "--help"}.intersection(words[1:]):
        print(parameter_help(Path(words[0]).stem, parameters))
        return 0
    with signals_end_the_loop():
        node = None
        try:
            _initialise(words)
            node = make_node()
            check_kept_to_this_machine(node)
            executor = make_executor([node])
            node.get_logger().info(getattr(node, "ready_words", "") or "running")
            spin(executor, until=lambda: getattr(node, "finished", False))
            executor.shutdown()
        except InputError as error:
            print(f"error: {error}", file=sys.stderr)
            return 2
        finally:
            leave_graph([] if node is None else [node])
    return getattr(node, "exit_status", 0)


def _initialise(arguments: list[str]) -> None:
    """Start ROS. Raises InputError on arguments that it does not understand, or would silently ignore."""
    keep_to_this_machine()
    try:
        rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
    except RuntimeError as error:
        raise InputError(f"arguments: {str(error).splitlines()[0]}; give --ros-args -p NAME:=VALUE") from None
    left = remove_ros_args(arguments)[1:]
    if left:
        raise InputError(f"arguments: {left[0]}: nodes take parameters only; give --ros-args -p NAME:=VALUE")

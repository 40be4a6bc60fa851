"""Replay, twin and monitor together: three nodes, one process, one executor. What `ema-twin live` runs."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import rclpy
from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions

from ema_bench_replay.nodes.loopback import check_kept_to_this_machine, keep_to_this_machine
from ema_bench_replay.nodes.record import RecordNode
from ema_bench_replay.nodes.replay import ReplayNode
from ema_bench_replay.nodes.spin import (
    all_received,
    leave_graph,
    make_executor,
    signals_end_the_loop,
    spin,
    steady_timer,
)
from ema_bench_replay.recording import Recording

from ..live.idle_time import IdleTime
from ..measured.noise import noise_of
from ..model import Model
from .live_session import PATIENCE, TICK, Change, HealthAsked, LiveResult, Pair, Session
from .monitor import MonitorNode
from .twin import TwinNode


def run_live(
    recording: Recording | None,
    model: Model,
    *,
    input: str = "auto",
    rate: float = 1.0,
    loop: bool = False,
    changes: Iterable[Change] = (),
    on_pairs: Callable[[Sequence[Pair]], None] | None = None,
    notify: Callable[[str], None] = lambda text: None,
    on_start: Callable[[MonitorNode], None] = lambda monitor: None,
    record_to: Path | None = None,
    max_bag_size: int = 0,
    max_bag_duration: float = 0.0,
    replaced: Sequence[Path] = (),
    health: HealthAsked | None = None,
    stop: threading.Event | None = None,
) -> LiveResult:
    """Play a recording to a twin and a monitor, all as ROS nodes in this process, until every sample was compared.

    Args:
        recording: what to play; None attaches to whatever publishes `bench/state`, from now on, until `stop`.
        model: the twin's model.
        input: what drives the twin: `setpoint`, `current`, or `auto`: the setpoint if the bench has one.
        rate: replay speed, 1 is real time, 0 as fast as possible.
        loop: begin again after the last sample, until `stop`.
        changes: parameters to set on the running twin, and when.
        on_pairs: called about 20 times a second with the pairs compared since.
        notify: called with one line of text when something happens.
        on_start: called once with the monitor, whose diagnosis_services may be asked from another thread.
        record_to: a new folder to make, for an MCAP of all topics.
        max_bag_size: bytes at which the recording's next file begins; 0: it is one file.
        max_bag_duration: s that a file of the recording spans at most; 0: it is one file.
        replaced: files of an earlier bag, deleted when everything is ready for the new one.
        health: by what to judge the running unit's health; None: it is not judged.
        stop: set it to end early, from another thread or from a callback.

    SIGINT and SIGTERM end it early too, if this is the process's main thread; the result then says `interrupted`.

    Raises:
        InputError: if a change is refused, `record_to` cannot be written, `health` names no usable unit, the twin's
            simulation diverges, or Fast DDS did not take the profile that keeps the nodes on this machine.
    """
    context = Context()
    stop = stop or threading.Event()
    nodes: list[Node] = []
    from_start = Parameter("from_start", value=recording is not None)
    source = Parameter("input", value=input)
    with signals_end_the_loop():  # until all is closed: a second Ctrl-C would cut off the bag
        keep_to_this_machine()
        rclpy.init(args=[], context=context, signal_handler_options=SignalHandlerOptions.NO)
        try:
            twin = TwinNode(model, parameters=[from_start, source], context=context)
            nodes.append(twin)
            check_kept_to_this_machine(twin)
            noise = None if recording is None else noise_of([recording], model)
            asked_health = [] if health is None else health.parameters
            given_monitor = [from_start, source, *asked_health]
            monitor = MonitorNode(model, parameters=given_monitor, context=context, noise=noise)
            nodes.append(monitor)
            replay = None
            if recording is not None:
                subscribers = len(nodes) + (record_to is not None)
                given = {"rate": float(rate), "loop": loop, "on_end": "wait", "subscribers": subscribers}
                replay = ReplayNode(
                    recording, parameters=[Parameter(k, value=v) for k, v in given.items()], context=context
                )
                nodes.append(replay)
            session = Session(twin, monitor, replay, sorted(changes), on_pairs, notify, stop)
            monitor.on_pair = session.take_pair
            steady_timer(monitor, TICK, session.tick)
            recorder = None
            if record_to is not None:  # last, since it replaces what was recorded before
                for path in replaced:
                    path.unlink()
                limits = {"max_bagfile_size": max_bag_size, "max_bagfile_duration": max_bag_duration}
                asked = {"output": str(record_to), **limits}
                recorder = RecordNode(parameters=[Parameter(k, value=v) for k, v in asked.items()], context=context)
                nodes.append(recorder)
            executor = make_executor(nodes, context)
            on_start(monitor)
            spin(executor, session.over, context)
            session.tick()
            if recorder is not None:  # the recorder may be a few messages behind the monitor
                lag = IdleTime(2.0 * TICK)
                spin(executor, lambda: all_received(nodes) or lag.look(None, time.monotonic()) > PATIENCE, context)
            executor.shutdown()
            if recorder is not None:
                recorder.close()
            return session.result(recording, recorder.faults if recorder is not None else "")
        finally:
            leave_graph(reversed(nodes), context)  # the recorder first

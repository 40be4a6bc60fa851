"""The services of the monitor: `monitor/diagnose` and `monitor/apply`, served beside it.

They are a node of their own, on an executor and in a thread of their own, and the judging is another process's: the
monitor's stream does not wait for any of it.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.context import Context
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node

from ema_bench_replay.errors import InputError
from ema_bench_replay.nodes import qos
from ema_twin_msgs.msg import Diagnosis
from ema_twin_msgs.srv import Apply, Diagnose

from ...model import Model
from .answer import diagnosis_message
from .apply import settings_for
from .frames import Answer
from .history import History
from .running_twin import RunningTwin
from .worker_process import WorkerProcess

_THREADS = 3
"""One that waits for a diagnosis, one that refuses a second, one for the twin's answers."""


@dataclass(frozen=True)
class Watched:
    """What the monitor lets its services see."""

    model: Model  # that it began with
    history: History
    place: Callable[[], tuple[str, int]]  # name of what is played, and the run
    changed: Callable[[], None]  # told when the twin has changed


class DiagnosisNode(Node):
    """Answers which effect the model lacks beside the last samples, and adds it to the running twin."""

    def __init__(self, watched: Watched, namespace: str, context: Context | None = None) -> None:
        super().__init__("monitor_services", namespace=namespace, context=context, use_global_arguments=False)
        self._watched = watched
        self._worker = WorkerProcess()
        self._twin = RunningTwin(self)
        self._busy = threading.Lock()
        self._last: Answer | None = None
        self._applied: dict[str, bool | float | str] = {}
        group = ReentrantCallbackGroup()
        self._publisher = self.create_publisher(Diagnosis, "monitor/diagnosis", qos.LATEST)
        self.create_service(Diagnose, "monitor/diagnose", self._on_diagnose, callback_group=group)
        self.create_service(Apply, "monitor/apply", self._on_apply, callback_group=group)
        self._executor = MultiThreadedExecutor(_THREADS, context=context)
        self._executor.add_node(self)
        self._thread = threading.Thread(target=self._serve, name="monitor services", daemon=True)
        self._thread.start()

    def prepare(self) -> None:
        """Start the process that judges, so that the first diagnosis need not wait for it."""
        self._worker.start()

    def diagnose(self, window: float = 0.0) -> Diagnosis:
        """Judge the present run, or its last `window` s; takes seconds.

        Raises InputError where there is nothing to judge, no twin answers, or another diagnosis is being made.
        """
        if not self._busy.acquire(blocking=False):
            raise InputError("a diagnosis is being made; call again when it has been published on monitor/diagnosis")
        try:
            if not 0.0 <= window <= 1e6:
                raise InputError(f"window {window} s is refused; give seconds, or 0 for the whole run")
            name, run = self._watched.place()
            recordings = self._watched.history.recordings(window, name)
            answer = self._worker.judge(recordings, *self._twin.models(self._watched.model, self._applied))
            if answer.diagnosis is None:
                raise InputError(answer.refusal)
            self._last = answer
        finally:
            self._busy.release()
        last = recordings[-1]
        judged = sum(recording.duration for recording in recordings)
        message = diagnosis_message(answer.diagnosis, last.start + int(last.stamps[-1]), run, judged)
        self._publisher.publish(message)
        return message

    def apply(self, effects: list[str]) -> str:
        """Switch effects of the last diagnosis on in the running twin (none named: all that it found); says what.

        Raises InputError where there was no diagnosis, it lacks one of them, or the twin refuses.
        """
        if self._last is None:
            raise InputError("nothing was diagnosed yet; call monitor/diagnose first")
        settings, words = settings_for(self._last, effects)
        absent = self._twin.change(settings)
        self._watched.changed()
        self._applied |= settings
        if absent:
            words += (
                f"; left out: {', '.join(absent)}, which the running twin has no place for: write the model with "
                "ema-twin discover, and start the twin with that"
            )
        return words

    def close(self) -> None:
        """End the thread and the process, whatever they are at."""
        self._worker.close()
        self._executor.shutdown(timeout_sec=1.0)
        self._thread.join(1.0)
        self.destroy_node()

    def _serve(self) -> None:
        try:
            self._executor.spin()
        except Exception as error:  # the context is shut down while it waits
            if self.context.ok():
                self.get_logger().error(f"monitor services ended: {error}")

    def _on_diagnose(self, request: Diagnose.Request, response: Diagnose.Response) -> Diagnose.Response:
        try:
            response.diagnosis = self.diagnose(request.window)
            response.success = True
        except InputError as error:
            response.message = str(error)
        return response

    def _on_apply(self, request: Apply.Request, response: Apply.Response) -> Apply.Response:
        try:
            response.message = self.apply(list(request.effect))
            response.success = True
        except InputError as error:
            response.message = str(error)
        return response

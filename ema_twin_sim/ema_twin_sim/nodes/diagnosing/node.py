"""The services of the monitor: `monitor/diagnose` and `monitor/apply`.

They are a separate node with its own executor and thread, and another process does the judging: the monitor's stream
does not wait for any of it.
"""

from __future__ import annotations

import threading
import traceback
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node

from ema_bench_replay.errors import InputError
from ema_bench_replay.nodes import qos
from ema_twin_msgs.msg import Diagnosis
from ema_twin_msgs.srv import Apply, Diagnose

from ...live.diagnosing.apply import Busy, NotDiagnosed, settings_for
from ...live.diagnosing.frames import Answer
from ...live.diagnosing.worker_process import WorkerProcess
from ...model import Model
from .answer import diagnosis_message
from .history import History
from .running_twin import RunningTwin

_THREADS = 3
"""One for the call in progress, one to refuse calls meanwhile, one for the twin's answers."""
_ENDING = 3.0
"""Time in s within which the call in progress must give up."""
_BUSY = "a diagnosis or apply is in progress; call again when it has finished (see monitor/diagnosis)"
_OVER = "the monitor is shutting down"

_VERDICTS = {
    "none": "these samples show no missing effect",
    "unknown": "something is missing that no effect explains",
}


@dataclass(frozen=True)
class Watched:
    """What the monitor shares with its services."""

    name: str  # of its node
    namespace: str
    names: Mapping[str, str]  # of services and topic, with the monitor's remappings
    twin: str  # name of the twin's node
    model: Model  # the monitor's model at the start
    history: History
    place: Callable[[], tuple[str, int]]  # name of the recording that is played, and the run


class DiagnosisNode(Node):
    """Diagnoses which effect the model lacks in the last samples, and adds it to the running twin."""

    def __init__(self, watched: Watched, context: Context | None = None) -> None:
        super().__init__(
            f"{watched.name}_services", namespace=watched.namespace, context=context, use_global_arguments=False
        )
        self._watched = watched
        self._worker = WorkerProcess()
        self._closing = threading.Event()
        self._twin = RunningTwin(self, watched.twin, self._closing)
        self._busy = threading.Lock()
        self._last: Answer | None = None
        self._applied: dict[str, bool | float | str] = {}
        self._added = False  # whether effects of the last diagnosis were added
        self._failure = ""  # of the last call; empty after one that succeeded
        group = ReentrantCallbackGroup()
        self._publisher = self.create_publisher(Diagnosis, watched.names["diagnosis"], qos.LATEST)
        self.create_service(Diagnose, watched.names["diagnose"], self._on_diagnose, callback_group=group)
        self.create_service(Apply, watched.names["apply"], self._on_apply, callback_group=group)
        self._executor = MultiThreadedExecutor(_THREADS, context=context)
        self._executor.add_node(self)
        self._thread = threading.Thread(target=self._serve, name="monitor services", daemon=True)
        self._thread.start()

    def prepare(self) -> None:
        """Start the judging process, so that the first diagnosis need not wait for it."""
        try:
            self._worker.start()
        except InputError as error:  # a diagnosis will say so too
            self._failure = str(error)
            self.get_logger().warning(str(error))

    def diagnose(self, window: float = 0.0) -> Diagnosis:
        """Judge the present run, or its last `window` s; takes seconds.

        Raises InputError if there is nothing to judge, no twin answers, or another call is in progress.
        """
        with self._alone():
            if not 0.0 <= window <= 1e6:
                raise InputError(f"window {window} s is out of range; give seconds, or 0 for the whole run")
            name, run = self._watched.place()
            recordings = self._watched.history.recordings(window, name)
            answer = self._worker.ask(recordings, *self._twin.models(self._watched.model, self._applied))
            if answer.diagnosis is None:
                raise InputError(answer.refusal)
            self._last, self._added = answer, False
            last = recordings[-1]
            judged = sum(recording.duration for recording in recordings)
            message = diagnosis_message(answer.diagnosis, last.start + int(last.stamps[-1]), run, judged)
            self._publisher.publish(message)
            return message

    def apply(self, effects: list[str]) -> str:
        """Switch effects of the last diagnosis on in the running twin (none named: all that it found); name them.

        Raises InputError if there was no diagnosis, it lacks one of them, the twin refuses, or another call is in
        progress.
        """
        with self._alone():
            if self._last is None:
                raise NotDiagnosed("nothing was diagnosed yet; call monitor/diagnose first")
            settings, words = settings_for(self._last, effects)
            self._applied |= self._twin.change(settings)
            self._added = True
            return words

    @property
    def condition(self) -> str:
        """What the last diagnosis found, for the monitor's diagnostics."""
        last = self._last
        if self._busy.locked():
            return "diagnosis or apply in progress"
        if self._failure:
            return f"no result: {self._failure}"
        if last is None or last.diagnosis is None:
            return "no diagnosis yet: call monitor/diagnose"
        found = [entry["effect"] for entry in last.diagnosis["ranking"] if entry["found"]]
        told = ", ".join(found) or _VERDICTS[last.diagnosis["verdict"]]
        return f"last diagnosis: {told}{'; since then added to the twin, fully or in part' if self._added else ''}"

    def close(self) -> None:
        """End the thread and the process, even if they are busy."""
        self._closing.set()
        self._worker.close()
        self._busy.acquire(timeout=_ENDING)  # the call in progress sees `_closing` and gives up
        self._executor.shutdown(timeout_sec=1.0)
        self._thread.join(1.0)
        self.destroy_node()

    @contextmanager
    def _alone(self) -> Iterator[None]:
        """Allow one call at a time: a diagnosis must be of the twin as it is when it is applied."""
        if self._closing.is_set():
            raise InputError(_OVER)
        if not self._busy.acquire(blocking=False):
            raise InputError(_OVER) if self._closing.is_set() else Busy(_BUSY)
        try:
            yield
            self._failure = ""
        except InputError as error:
            self._failure = str(error)
            raise
        finally:
            self._busy.release()

    def _serve(self) -> None:
        while self.context.ok() and not self._closing.is_set():
            try:
                self._executor.spin()
            except ExternalShutdownException:
                return
            except Exception as error:
                if self._closing.is_set() or not self.context.ok():  # the context was shut down meanwhile
                    return
                self.get_logger().error(f"{type(error).__name__}: {error}; the services go on")

    def _failed(self, error: Exception) -> str:
        """The message to the caller; an internal fault is also logged with its traceback."""
        if isinstance(error, InputError):
            return str(error)
        self.get_logger().error("".join(traceback.format_exception(error)))
        return f"internal error (traceback on the monitor's standard error): {type(error).__name__}: {error}"

    def _on_diagnose(self, request: Diagnose.Request, response: Diagnose.Response) -> Diagnose.Response:
        try:
            response.diagnosis = self.diagnose(request.window)
            response.success = True
        except Exception as error:  # whatever happens, the caller gets an answer and the services go on
            response.message = self._failed(error)
        return response

    def _on_apply(self, request: Apply.Request, response: Apply.Response) -> Apply.Response:
        try:
            response.message = self.apply(list(request.effect))
            response.success = True
        except Exception as error:  # whatever it is, the caller gets an answer, and the services go on
            response.message = self._failed(error)
        return response

"""The monitor's side of the process that diagnoses for it."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import threading
from collections.abc import Sequence
from pathlib import Path

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording

from ...effects.catalogue import own_files
from ...model import Model
from ...model.model_file import save_model
from .frames import Answer, Job, receive_answer, send

# do not import files of the folder where the monitor was started
_PROGRAM = f"import sys; del sys.path[0]; from {__package__}.worker import main; raise SystemExit(main())"
_OVER = "the monitor is shutting down; no further diagnosis"
_ENDING = 2.0
"""Time in s that the process has to end."""


class WorkerProcess:
    """Runs diagnoses in a separate process, never under the nodes' interpreter lock; one job at a time.

    The process starts when first needed, or at `start`, and stays for the next job: loading its libraries takes longer
    than most diagnoses.
    """

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._folder = tempfile.TemporaryDirectory(prefix="ema_twin_diagnosis_")
        self._starting = threading.Lock()
        self._closed = False

    def start(self) -> subprocess.Popen[bytes]:
        """Start the process if it is not running. Raises InputError if this object is closed or the start fails."""
        with self._starting:
            if self._closed:
                raise InputError(_OVER)
            if self._process is None or self._process.poll() is not None:
                try:
                    self._process = subprocess.Popen(
                        [sys.executable, "-c", _PROGRAM],
                        stdin=subprocess.PIPE,
                        stdout=subprocess.PIPE,
                        start_new_session=True,  # the nodes answer Ctrl-C, and close its input
                    )
                except OSError as error:
                    raise InputError(f"the diagnosis process cannot be started: {error}") from None
            return self._process

    def ask(self, recordings: Sequence[Recording], model: Model, base: Model) -> Answer:
        """Have recordings judged with a model; `base` is the same model without what earlier diagnoses added.

        Raises InputError if the process ended before it answered.
        """
        folder = Path(self._folder.name)
        present = save_model(model, folder / "present.yaml", force=True)
        before = save_model(base, folder / "base.yaml", force=True)
        job = Job(str(present), str(before), tuple(map(str, own_files())), tuple(recordings))
        process = self.start()
        assert process.stdin is not None and process.stdout is not None
        try:
            send(process.stdin, job)
            answer = receive_answer(process.stdout)
        except BrokenPipeError:
            answer = None
        if answer is None:
            if self._closed:
                raise InputError(_OVER)
            status = process.wait()
            raise InputError(
                f"the diagnosis process ended without an answer (status {status}); call again. Its messages are on the "
                "monitor's standard error"
            )
        return answer

    def close(self) -> None:
        """End the process, even during a job."""
        with self._starting:
            self._closed = True
            process = self._process
        if process is not None:
            process.terminate()
            try:
                process.wait(_ENDING)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self._folder.cleanup()

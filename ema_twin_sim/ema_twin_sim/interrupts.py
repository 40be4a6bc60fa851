"""Ctrl-C ends a command in one line at any moment, whatever is being imported or computed."""

from __future__ import annotations

import os
import signal
import sys
from contextlib import suppress
from types import FrameType

STATUS = 130
"""What an interrupted process ends with."""
_LINE = "interrupted; what is written is kept\n"
_IMPORTING = "<frozen importlib"

_seen = False


def watch() -> None:
    """Let Ctrl-C raise KeyboardInterrupt where work can be undone, and end the process where it would be garbled."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # a shell's background job
        return
    signal.signal(signal.SIGINT, _on_interrupt)
    sys.unraisablehook = _on_unraisable


def was_interrupted() -> bool:
    """Whether Ctrl-C came, whatever became of the KeyboardInterrupt."""
    return _seen


def finish(status: int) -> None:
    """End the process as done: from here on Ctrl-C comes too late, and would kill it without a word."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    sys.exit(status)


def end() -> None:
    """Say that the process was interrupted, and end it without waiting for its threads."""
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError):  # nobody may read it any more
            stream.flush()
    clear = "\r\x1b[K\x1b[?25h" if os.isatty(2) else ""  # a line of progress, and the cursor that it had hidden
    os.write(2, f"{clear}{_LINE}".encode())
    os._exit(STATUS)


def _on_interrupt(number: int, frame: FrameType | None) -> None:
    global _seen
    if _seen or _is_importing(frame):
        end()
    _seen = True
    raise KeyboardInterrupt


def _is_importing(frame: FrameType | None) -> bool:
    """Whether a module is being imported, which turns a KeyboardInterrupt into errors of all kinds."""
    while frame is not None:
        if frame.f_code.co_filename.startswith(_IMPORTING):
            return True
        frame = frame.f_back
    return False


def _on_unraisable(unraisable: sys.UnraisableHookArgs) -> None:
    if unraisable.exc_type is KeyboardInterrupt:  # raised where Python drops it: nobody would end
        end()
    sys.__unraisablehook__(unraisable)

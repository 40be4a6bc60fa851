"""The keys of a live run on the terminal: d (diagnose), a (add what was found), q (quit)."""

from __future__ import annotations

import math
import os
import select
import sys
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from ema_bench_replay.errors import InputError

from ..discovery.cautions import ALONE
from ..live.diagnosing.apply import Busy, NotDiagnosed
from ..quantities import estimate
from ..words.next_recording import recording_words
from ..words.sentences import beyond_words, effect_words
from .output import console, say

if TYPE_CHECKING:
    from ema_twin_msgs.msg import Diagnosis, Effect

    from ..nodes.diagnosing.node import DiagnosisNode
    from ..nodes.monitor import MonitorNode
    from .live_view import LiveView

Answer = TypeVar("Answer")
_HINT = "Keys: d diagnose   a add the effects found   q quit"
_BUSY = "A diagnosis is still being computed or added: wait for its result, then press the key again."
_ESCAPE = "\x1b"
_AT_ONCE = 64  # bytes
_SHOWN = 3
"""Number of a diagnosis's effects that are printed."""
_LOOK = 0.2
"""Interval in s at which the reader checks whether to end."""


class Keys:
    """Reads keys during a live run if standard input and output are a terminal; otherwise does nothing."""

    def __init__(self, stop: threading.Event, view: LiveView | None = None, output: Path | None = None) -> None:
        """``stop`` is set by q; ``view`` shows what was found and added; ``output`` is the file of the final twin."""
        self._stop = stop
        self._view = view
        self._output = output
        self._monitor: MonitorNode | None = None
        self._over = threading.Event()
        self._before: list[Any] | None = None
        self._threads: list[threading.Thread] = []

    def __enter__(self) -> Keys:
        if not (sys.stdin.isatty() and sys.stdout.isatty()):
            return self
        import termios
        import tty

        self._before = termios.tcgetattr(0)
        tty.setcbreak(0)
        console.print(_HINT, style="bold")
        return self

    def begin(self, monitor: MonitorNode) -> None:
        """Start to answer keys."""
        self._monitor = monitor
        if self._before is not None:
            self._in_a_thread(self._read)

    def press(self, key: str) -> None:
        """Do what the key stands for; of any other key, say which there are."""
        if key == "d":
            self._in_a_thread(self._diagnose)
        elif key == "a":
            self._in_a_thread(self._apply)
        elif key == "q":
            self._stop.set()
        elif not key.isspace():
            say(f"{repr(key) if key.isprintable() else 'That key'} does nothing. {_HINT}", style="dim")

    def __exit__(self, *_: object) -> None:
        self._over.set()
        for thread in self._threads:
            thread.join(2.0 * _LOOK)
        if self._before is not None:
            import termios

            termios.tcsetattr(0, termios.TCSADRAIN, self._before)

    def _in_a_thread(self, action: Any) -> None:
        thread = threading.Thread(target=action, daemon=True)
        thread.start()
        self._threads.append(thread)

    def _read(self) -> None:
        while not self._over.is_set():
            ready, _, _ = select.select([0], [], [], _LOOK)
            if ready:
                self.take(os.read(0, _AT_ONCE).decode(errors="replace"))

    def take(self, text: str) -> None:
        """Press the keys that were read at once; an arrow or function key is one key, of several characters."""
        for key in [text] if text.startswith(_ESCAPE) else text:
            self.press(key)

    def _diagnose(self) -> None:
        say("Diagnosing; this takes some seconds …", style="cyan")
        found = self._asked(lambda services: services.diagnose(), "No diagnosis")
        if found is None:
            return
        motion = "rotary" if self._monitor is None else self._monitor.model.motion
        lines = told(found, self._beyond(), motion)
        for line in lines:
            say(line, style="bold green")
        self._tell(lines[0])

    def _apply(self) -> None:
        words = self._asked(lambda services: services.apply([]), "Nothing added")
        if words is None:
            return
        say(f"Added to the running twin: {words}. Watch the error fall.", style="bold green")
        if self._output:
            say(f"It will be written to {self._output} at the end of the run.", style="green")
        else:
            say("It will not be saved: start live with -o NEW to save it.", style="green")
        self._tell(f"added: {words}")

    def _beyond(self) -> dict[str, float]:
        """The signals whose error exceeds the sensors' noise, and by what factor, as the monitor's health has it."""
        return {} if self._monitor is None else self._monitor.comparison.beyond_noise

    def _asked(self, ask: Callable[[DiagnosisNode], Answer], nothing: str) -> Answer | None:
        """What the running monitor's services answer; None, and why, if they refuse."""
        try:
            services = None if self._monitor is None else self._monitor.diagnosis_services
            if services is None:
                raise InputError("the run is over")
            return ask(services)
        except NotDiagnosed:
            refusal = "Nothing to add yet: press d to diagnose first."
        except Busy:
            refusal = _BUSY
        except (InputError, RuntimeError) as error:  # RuntimeError also from rclpy, if the run ends meanwhile
            refusal = f"{nothing}: {error}"
        say(refusal, style="yellow")
        return None

    def _tell(self, text: str) -> None:
        if self._view is not None:
            self._view.tell_now(text)


def told(found: Diagnosis, beyond: Mapping[str, float], motion: str = "rotary") -> list[str]:
    """A diagnosis in a few lines: what is missing, the likeliest effects, and what to record next.

    ``beyond`` holds the signals whose error exceeds the sensors' noise in the last window, and by what factor;
    ``motion`` is that of the machine.
    """
    effects = [entry for entry in found.ranking if entry.found]
    names = " and ".join(effect_words(entry.id) for entry in effects)
    if found.verdict == "none" and beyond:
        first = f"These samples show no missing effect, but {beyond_words(beyond)}."
    elif found.verdict == "none":
        first = "Nothing is missing: all errors are within the sensors' noise."
    elif found.verdict == "unknown":
        first = "Something is missing that no effect of the catalogue explains."
    else:
        first = f"Missing: {names}."
    lines = [f"{first} (based on {found.window:.0f} s)"]
    shown = [entry for entry in found.ranking[:_SHOWN] if entry.found or entry.probability > 0.0]
    lines += [f"  {_line(entry)}" for entry in shown]
    if effects:
        lines.append(f"Press a to add {'them' if len(effects) > 1 else 'it'} to the running twin.")
    if found.next_recording:
        lines.append(f"Record next: {recording_words(found.next_recording, motion)}")
    # leave out ALONE, which asks for more recordings: a live run has only one
    return [*lines, *(warning for warning in found.warnings if warning not in ALONE)]


def _line(entry: Effect) -> str:
    numbers = zip(entry.parameter, entry.value, entry.std, entry.unit, strict=True)
    words = ", ".join(f"{name} {estimate(value, std, unit)}" for name, value, std, unit in numbers)
    likely = f"{100.0 * entry.probability:.0f} % likely"
    removed = "" if math.isnan(entry.error_removed) else f", removes {100.0 * entry.error_removed:.0f} %"
    return f"{effect_words(entry.id)}: {likely}{removed} ({words})"

"""What the command line prints on: the console, sparklines, progress and warnings."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import TypeVar

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

_WIDTH_WITHOUT_TERMINAL = 140
_SECONDS_BETWEEN_LOG_LINES = 5.0

console = Console(highlight=False, width=None if sys.stdout.isatty() else _WIDTH_WITHOUT_TERMINAL)
messages = Console(stderr=True, highlight=False, soft_wrap=True)

_BARS = "▁▂▃▄▅▆▇█"

Item = TypeVar("Item")


def sparkline(values: Sequence[float]) -> str:
    """The values as bars between zero and their largest."""
    top = max(values, default=0.0)
    if not top > 0.0:
        return ""
    return "".join(_BARS[min(len(_BARS) - 1, int(len(_BARS) * value / top))] for value in values)


def warn(text: str) -> None:
    """One ``warning:`` line on the error output."""
    messages.print(f"warning: {' '.join(text.split())}", style="yellow", markup=False)


def tracked(items: Sequence[Item], what: str) -> Iterator[Item] | Iterable[Item]:
    """The items, with a progress bar where somebody watches and there is more than one."""
    with progress_bar() as progress:
        yield from progress.track(items, description=what)


@contextmanager
def status() -> Iterator[Callable[[str], None]]:
    """What takes a line of what is being done, and shows it on the error output; in a log, now and then."""
    if not sys.stderr.isatty():
        yield _now_and_then()
        return
    with messages.status("starting") as shown:
        yield lambda text: shown.update(f"{text} …")


def _now_and_then() -> Callable[[str], None]:
    begun = shown = time.monotonic()

    def show(text: str) -> None:
        nonlocal shown
        now = time.monotonic()
        if now - shown >= _SECONDS_BETWEEN_LOG_LINES:
            shown = now
            messages.print(f"{now - begun:.0f} s: {text} …", markup=False)

    return show


def progress_bar() -> Progress:
    """A progress bar on the error output, where somebody watches, that leaves no trace when done."""
    return Progress(
        TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(),
        console=messages, transient=True, disable=not sys.stderr.isatty(),
    )  # fmt: skip

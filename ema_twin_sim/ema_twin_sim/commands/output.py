"""What the command line prints on: the console, sparklines, progress and warnings."""

from __future__ import annotations

import logging
import os
import re
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.text import Text

_WIDTH_WITHOUT_TERMINAL = 120
_LEAST_WIDTH = 20
_SECONDS_BETWEEN_LOG_LINES = 5.0
_SECONDS_BETWEEN_SHARES = 0.1
_LONG = 90.0  # s, from which on a time is told in minutes


def _wanted_width() -> int | None:
    """The width that the environment asks for; None where it does not, or for none that anything fits in."""
    columns = os.environ.get("COLUMNS", "")
    return int(columns) if columns.isdecimal() and int(columns) >= _LEAST_WIDTH else None


def _width_without_terminal() -> int:
    """How wide output is that goes into a pipe: as the terminal that errors go to (``| less``), where there is one."""
    try:
        columns = os.get_terminal_size(sys.stderr.fileno()).columns
    except (OSError, ValueError, AttributeError):  # no terminal, or no error output at all
        return _WIDTH_WITHOUT_TERMINAL
    return min(max(columns, _LEAST_WIDTH), _WIDTH_WITHOUT_TERMINAL)


_folds = sys.stdout.isatty() or _wanted_width() is not None


class _Output(Console):
    def on_broken_pipe(self) -> None:
        """Raise BrokenPipeError: who reads the first lines only (``head``) has all that was asked for."""
        raise BrokenPipeError


console = _Output(
    highlight=False, width=_wanted_width() or (None if sys.stdout.isatty() else _width_without_terminal())
)
messages = Console(stderr=True, highlight=False, soft_wrap=True)

_BARS = "▁▂▃▄▅▆▇█"
# a blank that does not part a number from its unit or standard error, the words of a unit, or a sign from its word
_BREAK = re.compile(
    r"(?!(?<=\d) (?:%|±|°C|[nµmkM]?(?:A|V|s|Hz|rad|N|kg|m)\b)|(?<=±) |(?<=N) m\b|(?<=N m) s\b|(?<=V) s/|(?<=kg) m\b"
    r"|(?<=^[+−]) ) +|\n"
)


def say(text: str, *, style: str = "", markup: bool = False) -> None:
    """Print sentences: folded to the terminal or to ``COLUMNS``, between words; whole where there is neither."""
    said = Text.from_markup(text, style=style) if markup else Text(text, style)
    console.print(fold(said, console.width) if _folds else said, soft_wrap=True)


def fold(text: Text, width: int) -> Text:
    """The text in lines of at most ``width`` characters, with every number and its unit on one of them."""
    begin = end = resume = 0
    lines = []
    for stop, after in _pieces(text.plain):
        if stop - begin > width and end > begin:
            lines.append((begin, end))
            begin = resume
        while stop - begin > width:  # a word that is too long: broken after a mark within it, if need be anywhere
            marked = 1 + max(text.plain.rfind(mark, begin, begin + width) for mark in "._/-,")
            cut = marked if marked > begin else begin + width
            lines.append((begin, cut))
            begin = cut
        end, resume = stop, after
        if text.plain[stop:after] == "\n":
            lines.append((begin, end))
            begin = end = resume
    return Text("\n").join(text[first:last] for first, last in [*lines, (begin, end)])


def longest_piece(text: Text) -> int:
    """The length of the longest part of a text that ``fold`` keeps on one line."""
    begin = longest = 0
    for stop, after in _pieces(text.plain):
        longest, begin = max(longest, stop - begin), after
    return longest


def _pieces(text: str) -> Iterator[tuple[int, int]]:
    """Where each part that stays whole ends, and where the next begins; blanks that a line begins with are its own."""
    indent = len(text) - len(text.lstrip(" "))
    for blank in _BREAK.finditer(text, indent):
        yield blank.span()
    yield len(text), len(text)


def sparkline(values: Sequence[float]) -> str:
    """The values as bars between zero and their largest."""
    top = max(values, default=0.0)
    if not top > 0.0:
        return ""
    return "".join(_BARS[min(len(_BARS) - 1, int(len(_BARS) * value / top))] for value in values)


def warn(text: str) -> None:
    """One ``warning:`` line on the error output."""
    messages.print(f"warning: {' '.join(text.split())}", style="yellow", markup=False)


@contextmanager
def status() -> Iterator[Callable[[str], None]]:
    """What takes a line of what is being done, and shows it on the error output; in a log, now and then."""
    if not sys.stderr.isatty():
        yield _now_and_then()
        return
    with messages.status("starting") as shown:
        yield lambda text: shown.update(f"{text} …")


class Counted:
    """Pieces of work, ``total`` of them: takes the name of each when it is done.

    Told by a bar; in a log, by a line now and then. Both tell the time that is left, by how fast the last ones went.
    """

    def __init__(self, total: int, what: str, bar: Progress) -> None:
        self._total, self._what, self._bar = total, what, bar
        self._task = bar.add_task(what, total=total)
        self._begun = self._shown = time.monotonic()
        self._show = _now_and_then()
        self._done = 0
        self._under_way: dict[str, float] = {}

    def __call__(self, name: str) -> None:
        """Take the name of a piece that is done."""
        self._under_way.pop(name, None)
        self._done += 1
        self._bar.update(self._task, completed=self._so_far)
        self._log(f"{self._done} of {self._total} done ({name})")

    def within(self, name: str, share: float) -> None:
        """Take the share that is done of a long piece under way."""
        self._under_way[name] = share
        if time.monotonic() - self._shown > _SECONDS_BETWEEN_SHARES:
            self._shown = time.monotonic()
            self._bar.update(self._task, completed=self._so_far)
            self._log(f"{100.0 * share:.0f} % of {name}")

    @property
    def _so_far(self) -> float:
        return self._done + sum(list(self._under_way.values()))

    def _log(self, text: str) -> None:
        if self._bar.disable and 0.0 < self._so_far < self._total:
            left = (time.monotonic() - self._begun) / self._so_far * (self._total - self._so_far)
            self._show(f"{self._what}: {text}, about {duration(left)} left")


@contextmanager
def counted(total: int, what: str) -> Iterator[Counted]:
    """What counts ``total`` pieces of work as they are done."""
    with progress_bar(TextColumn("left:"), TimeRemainingColumn(elapsed_when_finished=True)) as bar:
        yield Counted(total, what, bar)


def duration(seconds: float) -> str:
    """A time as one says it: 40 s, 12 min, 3 h 20 min."""
    if seconds < _LONG:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60.0)
    return f"{minutes} min" if minutes < 60 else f"{minutes // 60} h {minutes % 60} min"


def tell_of_compiling() -> None:
    """Show on the error output what the package tells of work that takes long and comes once."""
    handler = logging.Handler(logging.INFO)
    handler.emit = lambda record: messages.print(record.getMessage(), markup=False)  # type: ignore[method-assign]
    package = logging.getLogger("ema_twin_sim")
    package.setLevel(logging.INFO)
    package.addHandler(handler)


def _now_and_then() -> Callable[[str], None]:
    begun = shown = time.monotonic()

    def show(text: str) -> None:
        nonlocal shown
        now = time.monotonic()
        if now - shown >= _SECONDS_BETWEEN_LOG_LINES:
            shown = now
            messages.print(f"{now - begun:.0f} s: {text} …", markup=False)

    return show


def progress_bar(*more: ProgressColumn) -> Progress:
    """A progress bar on the error output, where somebody watches, that leaves no trace when done."""
    return Progress(
        TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), *more,
        console=messages, transient=True, disable=not sys.stderr.isatty(),
    )  # fmt: skip

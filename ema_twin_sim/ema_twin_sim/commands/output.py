"""Output of the command line: console, sparklines, progress and warnings."""

from __future__ import annotations

import logging
import os
import re
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.text import Text

_WIDTH_WITHOUT_TERMINAL = 120
_LEAST_WIDTH = 20
_SECONDS_BETWEEN_LOG_LINES = 5.0
_SECONDS_BETWEEN_SHARES = 0.1
_LONG = 90.0  # s; longer times are given in minutes


def _wanted_width() -> int | None:
    """The width that ``COLUMNS`` asks for; None if it is not set, or less than 20 characters."""
    columns = os.environ.get("COLUMNS", "")
    return int(columns) if columns.isdecimal() and int(columns) >= _LEAST_WIDTH else None


def _width_without_terminal() -> int:
    """Width of output into a pipe (``| less``): that of the terminal of the error output, at most 120 characters.

    120 characters if the error output is no terminal either.
    """
    try:
        columns = os.get_terminal_size(sys.stderr.fileno()).columns
    except (OSError, ValueError, AttributeError):  # no terminal, or no error output at all
        return _WIDTH_WITHOUT_TERMINAL
    return min(max(columns, _LEAST_WIDTH), _WIDTH_WITHOUT_TERMINAL)


_folds = sys.stdout.isatty() or _wanted_width() is not None


class _Output(Console):
    def on_broken_pipe(self) -> None:
        """Raise BrokenPipeError: a reader of the first lines only (``head``) has all that it asked for."""
        raise BrokenPipeError


console = _Output(
    highlight=False, width=_wanted_width() or (None if sys.stdout.isatty() else _width_without_terminal())
)
messages = Console(stderr=True, highlight=False, soft_wrap=True)

_BARS = "▁▂▃▄▅▆▇█"
# blanks where a line may break: not between a number and its unit or standard error, not within a unit, and not after
# a sign at the beginning
_BREAK = re.compile(
    r"(?!(?<=\d) (?:%|±|°C|[nµmkM]?(?:A|V|s|Hz|rad|N|kg|m)\b)|(?<=±) |(?<=N) m\b|(?<=N m) s\b|(?<=V) s/|(?<=kg) m\b"
    r"|(?<=^[+−]) ) +|\n"
)


COMMAND = "  ema-twin "
"""How a line begins that holds a command."""


def say(text: str, *, style: str = "", markup: bool = False) -> None:
    """Print sentences, folded between words to the terminal's width or ``COLUMNS``; unfolded if there is neither.

    Commands to be copied are not folded.
    """
    said = Text.from_markup(text, style=style) if markup else Text(text, style)
    folds = _folds and not said.plain.startswith(COMMAND)
    console.print(fold(said, console.width) if folds else said, soft_wrap=True)


def takes_colours(environment: Mapping[str, str] = os.environ) -> bool:
    """Whether the terminal shows colours, and nobody asked for none; else their codes would be printed as text."""
    return not environment.get("NO_COLOR") and environment.get("TERM", "dumb") not in ("dumb", "unknown")


def unfolded(text: str) -> None:
    """Print a line as it is: neither folded nor read as markup."""
    console.print(text, markup=False, soft_wrap=True)


def fold(text: Text, width: int) -> Text:
    """The text folded to lines of at most ``width`` characters; a number and its unit stay on one line."""
    begin = end = resume = 0
    lines = []
    for stop, after in _pieces(text.plain):
        if stop - begin > width and end > begin:
            lines.append((begin, end))
            begin = resume
        while stop - begin > width:  # a word is too long: break it after a mark within it, else anywhere
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
    """Length of the longest part of a text that ``fold`` keeps on one line."""
    begin = longest = 0
    for stop, after in _pieces(text.plain):
        longest, begin = max(longest, stop - begin), after
    return longest


def _pieces(text: str) -> Iterator[tuple[int, int]]:
    """Yield where each unbreakable part ends and the next one begins; leading blanks belong to the first part."""
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
    """Print one ``warning:`` line on the error output."""
    messages.print(f"warning: {' '.join(text.split())}", style="yellow", markup=False)


@contextmanager
def status() -> Iterator[Callable[[str], None]]:
    """Yield a function that shows what is being done on the error output; without a terminal, every 5 s at most."""
    if not sys.stderr.isatty():
        yield _now_and_then()
        return
    with messages.status("starting") as shown:
        yield lambda text: shown.update(f"{text} …")


class Counted:
    """Counter of ``total`` pieces of work; call it with the name of each piece when that is done.

    Shown as a bar; without a terminal, as a line every 5 s at most. Both give the time left: the bar by the speed of
    the last pieces, the line by the average speed since the first piece, which also took the start of the workers. Of
    these, as much time must have passed as that one took.
    """

    def __init__(self, total: int, what: str, bar: Progress) -> None:
        self._total, self._what, self._bar = total, what, bar
        self._task = bar.add_task(what, total=total)
        self._begun = self._shown = time.monotonic()
        self._show = _now_and_then()
        self._done = 0
        self._first: tuple[float, float] | None = None  # when the first piece was done, and how many pieces were then
        self._under_way: dict[str, float] = {}

    def __call__(self, name: str) -> None:
        """Take the name of a piece that is done."""
        self._under_way.pop(name, None)
        self._done += 1
        if self._first is None:
            self._first = time.monotonic(), self._so_far
        self._bar.update(self._task, completed=self._so_far)
        self._log(f"{self._done} of {self._total} done ({name})")

    def within(self, name: str, share: float) -> None:
        """Take the fraction that is done of a long piece in progress."""
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
            left = self._seconds_left()
            self._show(f"{self._what}: {text}{'' if left is None else f', about {duration(left)} left'}")

    def _seconds_left(self) -> float | None:
        """The time left; None if it cannot be told yet."""
        now, so_far = time.monotonic(), self._so_far
        if self._first is None:  # within the first piece
            return (now - self._begun) / so_far * (self._total - so_far)
        at, then = self._first
        if so_far <= then or now - at < at - self._begun:
            return None
        return (now - at) / (so_far - then) * (self._total - so_far)


@contextmanager
def counted(total: int, what: str) -> Iterator[Counted]:
    """Yield a counter of ``total`` pieces of work; its bar is on the error output, and disappears when done."""
    columns = (
        TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(),
        TextColumn("left:"), TimeRemainingColumn(elapsed_when_finished=True),
    )  # fmt: skip
    with Progress(*columns, console=messages, transient=True, disable=not sys.stderr.isatty()) as bar:
        yield Counted(total, what, bar)


def duration(seconds: float) -> str:
    """A duration in words: 40 s, 12 min, 3 h 20 min."""
    if seconds < _LONG:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60.0)
    return f"{minutes} min" if minutes < 60 else f"{minutes // 60} h {minutes % 60} min"


def tell_of_compiling() -> None:
    """Print the package's log messages (INFO: long work that is done once, such as compiling) on the error output."""
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

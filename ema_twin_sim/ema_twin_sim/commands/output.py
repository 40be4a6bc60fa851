"""What the command line prints: engineering numbers, tables, sparklines, progress and warnings."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Iterator, Sequence
from typing import TypeVar

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

console = Console(highlight=False, soft_wrap=False)
messages = Console(stderr=True, highlight=False, soft_wrap=True)

_PREFIXES = ((1e-9, "n"), (1e-6, "µ"), (1e-3, "m"), (1.0, ""), (1e3, "k"), (1e6, "M"))
_BARS = "▁▂▃▄▅▆▇█"

Item = TypeVar("Item")


def quantity(value: float | None, unit: str, digits: int = 3) -> str:
    """``0.00301, 'A'`` as ``3.01 mA``; a dash where there is no value."""
    if value is None or not math.isfinite(value):
        return "–"
    if value == 0.0:
        return f"0 {unit}"
    scale, prefix = next(
        ((s, p) for s, p in reversed(_PREFIXES) if abs(value) >= s * (1.0 - 0.5 * 10.0**-digits)), _PREFIXES[0]
    )
    number = value / scale
    decimals = max(0, digits - 1 - math.floor(math.log10(abs(number)))) if number else 0
    return f"{number:.{decimals}f} {prefix}{unit}"


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
    if len(items) < 2 or not sys.stderr.isatty():
        yield from items
        return
    with progress_bar() as progress:
        yield from progress.track(items, description=what)


def progress_bar() -> Progress:
    """A progress bar on the error output that leaves no trace when done."""
    return Progress(
        TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(),
        console=messages, transient=True,
    )  # fmt: skip

"""Pieces of work side by side on two cores, where that is quicker than one after another."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

_MANY = 30_000
"""Samples from which on a prediction takes long enough: below, threads mostly wait for the interpreter's lock, and one
after another is quicker by a quarter."""

T = TypeVar("T")
U = TypeVar("U")

_here = threading.local()


def _begin() -> None:
    _here.side_by_side = True


_POOL = ThreadPoolExecutor(2, initializer=_begin)


def simulations(work: Callable[[T], U], jobs: Iterable[T]) -> Iterator[U]:
    """As ``map``; for work that simulates, which holds no lock."""
    return _mapped(work, jobs)


def predictions(samples: int, work: Callable[..., U], *jobs: Iterable[object]) -> Iterator[U]:
    """As ``map``; for work that predicts ``samples`` samples, once or many times."""
    return _mapped(work, *jobs) if samples >= _MANY else map(work, *jobs)


def _mapped(work: Callable[..., U], *jobs: Iterable[object]) -> Iterator[U]:
    """As ``map``, side by side, unless there is one piece only, or this is one of several that are side by side."""
    pieces = list(zip(*jobs, strict=True))
    if len(pieces) < 2 or getattr(_here, "side_by_side", False):
        return (work(*piece) for piece in pieces)
    return _POOL.map(lambda piece: work(*piece), pieces)

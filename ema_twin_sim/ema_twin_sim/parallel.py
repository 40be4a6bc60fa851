"""Pieces of work side by side on the cores of this machine, where that is quicker than one after another."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

_MANY = 30_000
"""Samples from which on a prediction takes long enough: below, threads mostly wait for the interpreter's lock, and one
after another is quicker by a quarter."""

U = TypeVar("U")

_here = threading.local()


def one_after_another() -> None:
    """Do everything that this thread asks for in this thread from now on: others have the other cores."""
    _here.alone = True


_POOL = ThreadPoolExecutor(2, initializer=one_after_another)
_OF_ALL_CORES = ThreadPoolExecutor(os.cpu_count(), initializer=one_after_another)


def simulations(work: Callable[..., U], *jobs: Iterable[object]) -> Iterator[U]:
    """As ``map``; for work that simulates, which holds no lock."""
    return _mapped(_OF_ALL_CORES, work, *jobs)


def predictions(samples: int, work: Callable[..., U], *jobs: Iterable[object]) -> Iterator[U]:
    """As ``map``; for work that predicts ``samples`` samples, once or many times."""
    return _mapped(_POOL, work, *jobs) if samples >= _MANY else map(work, *jobs)


def _mapped(pool: ThreadPoolExecutor, work: Callable[..., U], *jobs: Iterable[object]) -> Iterator[U]:
    """As ``map``, side by side, unless there is one piece only, or this is one of several that are side by side."""
    pieces = list(zip(*jobs, strict=True))
    if len(pieces) < 2 or getattr(_here, "alone", False):
        return (work(*piece) for piece in pieces)
    return pool.map(lambda piece: work(*piece), pieces)

"""Which results of a unit are healthy: those that its others are held against."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from ema_bench_replay.errors import InputError

PART_OF_ALL = 3
"""One in so many of the first are, unless it is said which."""


@dataclass(frozen=True)
class Healthy:
    """The first ``count`` results, or those in whose name a ``pattern`` is found; neither: the first third."""

    count: int | None = None
    pattern: re.Pattern[str] | None = None

    @classmethod
    def of(cls, text: str | None, fewest: int) -> Healthy:
        """From a number or a regular expression. Raises InputError where it is neither, or the number is too small."""
        if text is None:
            return cls()
        if text.isdecimal():
            if int(text) < fewest:
                raise InputError(f"--healthy {text}: so few results tell no scatter; give {fewest} or more")
            return cls(count=int(text))
        try:
            return cls(pattern=re.compile(text))
        except re.error as error:
            raise InputError(f"--healthy {text}: is no number and no regular expression ({error})") from None

    def of_history(self, names: Sequence[str], fewest: int) -> list[bool]:
        """Of each result that has a number, in the order in which they were recorded, whether it is healthy.

        A pattern may find fewer than ``fewest``; unless it is said, they are the first.
        """
        if self.pattern is not None:
            return [bool(self.pattern.search(name)) for name in names]
        count = max(fewest, len(names) // PART_OF_ALL) if self.count is None else self.count
        return [k < count for k in range(len(names))]

    def among(self, names: Sequence[str], tests: Sequence[str], fewest: int) -> list[bool]:
        """Of each result, in the order in which they were recorded, whether it is; unless it is said, by whole tests,
        ``fewest`` of them at least.
        """
        if self.pattern is not None:
            return [bool(self.pattern.search(name)) for name in names]
        if self.count is not None:
            return [k < self.count for k in range(len(names))]
        order = list(dict.fromkeys(tests))
        first = {*order[: max(fewest, len(order) // PART_OF_ALL)]}
        return [test in first for test in tests]


BY_DEFAULT = Healthy()
"""The first third."""

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

    def first(self, names: Sequence[str], fewest: int) -> int:
        """How many of the first results, in the order in which they were recorded, are healthy."""
        count = self.count
        if self.pattern is not None:
            flags = [bool(self.pattern.search(name)) for name in names]
            count = flags.index(False) if False in flags else len(flags)
        if count is None or (self.pattern is not None and count < fewest):
            count = max(fewest, len(names) // PART_OF_ALL)
        return min(count, len(names))

    def follows(self, names: Sequence[str], fewest: int) -> bool:
        """Whether ``first`` does what was said: of a pattern it takes those that the history begins with."""
        return self.pattern is None or all(self.pattern.search(name) for name in names[:fewest])

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

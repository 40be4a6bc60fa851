"""Which results of a unit are healthy, that is, the reference for its other results."""

from __future__ import annotations

import re
from collections.abc import Hashable, Sequence
from dataclasses import dataclass

from ema_bench_replay.errors import InputError

PART_OF_ALL = 3
"""By default, the first 1 / ``PART_OF_ALL`` of the results are healthy."""


@dataclass(frozen=True)
class Healthy:
    """The first ``count`` results, or those with ``pattern`` in their name; with neither, the first third."""

    count: int | None = None
    pattern: re.Pattern[str] | None = None

    @classmethod
    def of(cls, text: str | None, fewest: int) -> Healthy:
        """From a number or a regular expression. Raises InputError if it is neither, or less than ``fewest``."""
        if text is None:
            return cls()
        if text.isdecimal():
            if int(text) < fewest:
                raise InputError(f"--healthy {text}: too few results to estimate the scatter; give {fewest} or more")
            return cls(count=int(text))
        try:
            return cls(pattern=re.compile(text))
        except re.error as error:
            raise InputError(f"--healthy {text}: is no number and no regular expression ({error})") from None

    def among(self, names: Sequence[str], tests: Sequence[Hashable], fewest: int) -> list[bool]:
        """Whether each result is healthy, in the order of recording; by default ``fewest`` whole tests or more are.

        Of the first ``count`` results, the tests that they belong to are healthy as a whole: a test was set up once. A
        pattern may find fewer.
        """
        if self.pattern is not None:
            return [bool(self.pattern.search(name)) for name in names]
        if self.count is not None:
            first = {*tests[: self.count]}
            return [test in first for test in tests]
        order = list(dict.fromkeys(tests))
        first = {*order[: max(fewest, len(order) // PART_OF_ALL)]}
        return [test in first for test in tests]


BY_DEFAULT = Healthy()
"""The first third."""

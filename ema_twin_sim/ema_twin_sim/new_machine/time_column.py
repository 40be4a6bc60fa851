"""Which column of a trace is the time."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ema_bench_replay.traces.header_words import HeaderWords, in_other_letters

from .clock import is_uneven
from .column_quantity import has_word, word_quantity
from .column_words import NO_CLOCK, NO_CLOCK_IN_OTHER_LETTERS, NO_SIGNAL, TIME_IN_OTHER_LETTERS, TIME_WORDS
from .shared_words import shared_words


def time_column(names: Sequence[HeaderWords], numbers: Mapping[str, np.ndarray]) -> HeaderWords | None:
    """The time column: by its name, or by a unit of time; of several, the first that rises.

    One with both is the clock even if it does not rise: reading it tells what is wrong with it. One with the unit alone
    that goes in uneven steps comes after those that go in even ones, as clocks do, and must not be named something
    else: the slip of a motor may be given in s as well. One that only numbers the rows, as a ``timestep`` may, is the
    clock if no other column is. Words with which all names begin, as those of a program or a topic, tell nothing.
    """
    called = [read for read in names if _is_called_time(read, names)]
    others = [read for read in names if read.quantity == "time" and read not in called]
    if called and not numbers:
        return called[0]
    rising = [read for read in (*called, *others) if read.name in numbers and (np.diff(numbers[read.name]) > 0.0).all()]
    uneven = [read for read in rising if read not in called and is_uneven(numbers[read.name])]
    clocks = [read for read in called if read.quantity == "time"]
    counters = [read for read in rising if read.unit is None and _numbers_rows(numbers[read.name])]
    by_name = [read for read in rising if read in called and read not in counters]
    by_steps = [read for read in rising if read not in (*uneven, *counters)]
    assumed = [read for read in uneven if not _is_something_else(read)]
    if not (by_name or by_steps or assumed):
        by_name = counters
    return next(iter((*by_name, *clocks, *by_steps, *assumed, *called)), None)


def is_assumed(time: HeaderWords, names: Sequence[HeaderWords], numbers: Mapping[str, np.ndarray]) -> bool:
    """Whether a time column has neither the name of a time nor even steps, so that only its unit tells it."""
    return not _is_called_time(time, names) and time.name in numbers and is_uneven(numbers[time.name])


def _is_called_time(read: HeaderWords, names: Sequence[HeaderWords]) -> bool:
    """Whether one of the names is that of a time, apart from the words with which all begin."""
    return _is_time(replace(read, words=read.words[shared_words(names) :]))


def _numbers_rows(values: np.ndarray) -> bool:
    """Whether values (n,) are whole numbers that rise by one from row to row."""
    return len(values) > 1 and float(values[0]).is_integer() and bool((np.diff(values) == 1.0).all())


def _is_something_else(read: HeaderWords) -> bool:
    """Whether the words of a column whose unit is one of time name what is no clock."""
    if has_word(read.words, f"{NO_CLOCK}|{NO_SIGNAL}") or re.search(NO_CLOCK_IN_OTHER_LETTERS, read.name.lower()):
        return True
    return word_quantity(read.words) not in (None, "time")


def _is_time(read: HeaderWords) -> bool:
    if read.quantity not in ("time", None) or read.foreign:
        return False
    if not read.words and in_other_letters(read.name):
        return re.search(TIME_IN_OTHER_LETTERS, read.name.lower()) is not None
    known = all(re.search(TIME_WORDS, word) for word in read.words) and bool(read.words or read.quantity)
    if read.quantity == "time":
        # the x axis of a plot is time if its unit is one of time
        return known or word_quantity(read.words) == "time" or read.words == ("x",)
    if read.words == ("x", "value"):  # LabVIEW's name for the time of a measurement
        return True
    return known or (has_word(read.words, r"time|zeit|stamp") and not has_word(read.words, NO_SIGNAL))

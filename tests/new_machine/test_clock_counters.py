"""A counter that rises at a constant rate is a clock, and no encoder; a column that says position is the position."""

import numpy as np
import pytest

from ema_bench_replay.traces.header_words import COUNTS, header_words
from tests.taken_columns import guessed, taken

MS = np.cumsum(np.where(np.arange(900) % 50 == 7, 106.0, 32.0))
TICK = (28228.0 + MS) % 32768.0
POSITION = np.rint(40.0 * np.sin(4e-4 * MS))


@pytest.mark.parametrize("name", ["Realtime Tick", "Timestamp [ticks]", "Tick", "counts", "cycle counter [count]"])
@pytest.mark.parametrize("word", [32768.0, 1e5, 1e9])
def test_a_clock_of_its_own_beside_the_time_is_no_position(name, word):
    columns = {"Time[ms]": MS, name: (28228.0 + MS) % word, "Present Position": POSITION}
    guesses = guessed(columns)
    assert taken(columns) == {"motor_position": "Present Position"}
    assert guesses.time.column == "Time[ms]" and guesses.clock_counters == (name,) and name in guesses.left


def test_a_clock_of_another_rate_that_is_read_a_little_late():
    ticks = np.floor(1234.5 + 0.625 * (MS + np.random.default_rng(3).uniform(0.0, 2.0, len(MS))))
    columns = {"t [ms]": MS, "ticks": ticks, "Present Position": POSITION}
    assert guessed(columns).clock_counters == ("ticks",)


@pytest.mark.parametrize("name", ["motor [counts]", "encoder [counts]", "position [counts]", "Output counts"])
def test_a_shaft_that_turns_steadily_is_one_all_the_same(name):
    columns = {"Time[ms]": MS, name: TICK, "current [A]": POSITION}
    guesses = guessed(columns)
    assert guesses.clock_counters == () and name in taken(columns).values()


@pytest.mark.parametrize("moves", [1.0, 3.0])
def test_a_counter_that_reverses_or_starts_from_rest_is_a_position(moves):
    counts = np.rint(20000.0 * (1.0 - np.cos(moves * np.pi * MS / MS[-1])))
    columns = {"Time[ms]": MS, "counts": counts, "current [A]": POSITION}
    assert taken(columns)["motor_position"] == "counts"


def test_what_only_counts_comes_after_what_says_position():
    counts = np.rint(20000.0 * np.sin(3e-4 * MS) + 300.0 * np.sin(1e-2 * MS))
    columns = {"Time[ms]": MS, "pulses": counts, "Present Position": POSITION}
    assert taken(columns)["motor_position"] == "Present Position"


@pytest.mark.parametrize("name", ["motor ticks", "encoder [ticks]", "Ticks", "Position (counts)"])
def test_ticks_of_no_time_are_counts(name):
    assert header_words(name).unit == COUNTS


def test_init_says_so(drafted):
    draft = drafted({"Time[ms]": MS, "Realtime Tick": TICK, "Present Position": POSITION})
    assert "Realtime Tick: not used, since it counts at a constant rate, as a clock does" in draft.said
    assert "Present Position → motor_position" in draft.said and "32768" not in draft.told

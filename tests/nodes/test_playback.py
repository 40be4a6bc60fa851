"""Which sample of a recording is due when: absolute deadlines, pauses, steps, seeks and loops."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ema_bench_replay.errors import InputError
from ema_bench_replay.nodes.playback import Playback

MS = 1_000_000
STAMPS = np.arange(10, dtype=np.int64) * 2 * MS


def played_until(playback, now):
    """Indices of the samples that are due up to `now`, which are then played."""
    indices = []
    while (wait := playback.wait(now)) is not None and wait <= 0:
        indices.append(playback.next)
        playback.played()
    return indices


def test_samples_are_due_at_their_times_over_the_rate():
    playback = Playback(STAMPS, rate=2.0, now=1000 * MS)
    assert played_until(playback, 1000 * MS) == [0]
    assert playback.wait(1000 * MS) == 1 * MS
    assert played_until(playback, 1003 * MS) == [1, 2, 3]
    assert played_until(playback, 2000 * MS) == [4, 5, 6, 7, 8, 9]
    assert playback.ended
    assert playback.wait(3000 * MS) is None


@given(st.lists(st.integers(0, 10 * MS), min_size=1, max_size=200))
def test_late_calls_shift_no_deadline(steps):
    stamps = np.arange(100, dtype=np.int64) * 2 * MS
    playback = Playback(stamps)
    now = 0
    for step in steps:
        now += step
        played_until(playback, now)
        assert playback.next == min(now // (2 * MS) + 1, 100)


def test_unequal_steps_are_kept():
    playback = Playback(np.array([0, 2, 3, 10], np.int64) * MS)
    waits = []
    now = 0
    while not playback.ended:
        wait = playback.wait(now)
        waits.append(wait // MS)
        now += wait
        playback.played()
    assert waits == [0, 2, 1, 7]


def test_a_pause_is_no_new_pass_and_loses_nothing():
    playback = Playback(STAMPS)
    assert played_until(playback, 4 * MS) == [0, 1, 2]
    playback.pause()
    assert playback.wait(100 * MS) is None
    assert playback.position(100 * MS) == 4 * MS
    playback.resume(100 * MS)
    assert played_until(playback, 100 * MS) == [3]
    assert playback.wait(100 * MS) == 2 * MS
    assert playback.passes == 1


def test_resume_while_playing_changes_nothing():
    playback = Playback(STAMPS)
    played_until(playback, 1 * MS)
    playback.resume(1 * MS)
    assert playback.wait(1 * MS) == 1 * MS


def test_steps_while_paused():
    playback = Playback(STAMPS, paused=True)
    assert played_until(playback, 50 * MS) == []
    playback.step()
    playback.step()
    assert played_until(playback, 50 * MS) == [0, 1]
    playback.resume(60 * MS)
    with pytest.raises(InputError, match="pause it first"):
        playback.step()


def test_step_at_the_end_is_refused():
    playback = Playback(STAMPS, rate=0.0)
    played_until(playback, 0)
    playback.pause()
    with pytest.raises(InputError, match="seek back"):
        playback.step()


def test_seek_begins_a_pass_there():
    playback = Playback(STAMPS)
    played_until(playback, 4 * MS)
    playback.seek(0.013, 10 * MS)
    assert (playback.first, playback.next, playback.passes) == (7, 7, 2)
    assert played_until(playback, 10 * MS) == [7]
    playback.seek(0.0, 11 * MS)
    assert (playback.first, playback.passes) == (0, 3)


def test_rate_zero_is_always_due_and_after_a_seek_from_the_end_again():
    playback = Playback(STAMPS, rate=0.0)
    assert played_until(playback, 0) == list(range(10))
    playback.seek(0.0, 1)
    assert played_until(playback, 1) == list(range(10))


@pytest.mark.parametrize("position", [-0.001, 0.0181, float("nan")])
def test_seek_outside_is_refused_with_the_range(position):
    playback = Playback(STAMPS)
    with pytest.raises(InputError, match=r"0 to 0\.018 s"):
        playback.seek(position, 0)
    assert playback.passes == 1


def test_loop_returns_to_the_start_one_period_after_the_last_sample():
    playback = Playback(STAMPS, loop=True, start=0.014)
    assert played_until(playback, 4 * MS) == [7, 8, 9]
    assert playback.passes == 2
    assert playback.wait(4 * MS) == 2 * MS
    assert played_until(playback, 10 * MS) == [7, 8, 9]
    assert not playback.ended


def test_position_moves_on_between_samples_but_not_past_the_next():
    playback = Playback(STAMPS, rate=0.5)
    played_until(playback, 0)
    assert playback.position(2 * MS) == 1 * MS
    assert playback.position(50 * MS) == 2 * MS


def test_rate_changes_from_the_next_sample_on():
    playback = Playback(STAMPS)
    played_until(playback, 2 * MS)
    playback.set_rate(4.0, 3 * MS)
    assert played_until(playback, 4 * MS) == [2, 3, 4]


def test_one_sample_is_a_recording_too():
    playback = Playback(np.zeros(1, np.int64))
    assert played_until(playback, 0) == [0]
    assert playback.ended

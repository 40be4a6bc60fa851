"""A twin's own clock: deadlines do not drift, and what is missed is counted."""

from hypothesis import given
from hypothesis import strategies as st

from ema_twin_sim.live.real_time import DeadlineClock

MS = 1_000_000


def test_periods_begin_at_absolute_deadlines():
    clock = DeadlineClock(2 * MS, now=100 * MS)
    assert clock.tick(99 * MS) is None
    assert clock.tick(100 * MS) == 0
    assert clock.tick(101 * MS) is None
    assert clock.tick(102 * MS + 300) == 1
    assert (clock.missed, clock.worst) == (0, 300)


def test_a_timer_that_is_a_little_early_misses_nothing():
    clock = DeadlineClock(2 * MS, now=MS // 10)  # the first call was late
    assert clock.tick(MS // 10) == 0
    assert [clock.tick(n * 2 * MS + n % 3 * MS // 20) for n in range(1, 100)] == list(range(1, 100))
    assert clock.missed == 0


def test_missed_periods_are_counted_and_not_made_up_for():
    clock = DeadlineClock(2 * MS, now=0)
    clock.tick(0)
    assert clock.tick(9 * MS) == 4
    assert clock.missed == 3
    assert clock.worst == 7 * MS


@given(st.lists(st.integers(1, 20 * MS), max_size=100))
def test_numbers_rise_and_every_period_is_either_served_or_missed(steps):
    clock = DeadlineClock(2 * MS, now=0)
    served, last, now = 0, -1, 0
    for step in steps:
        now += step
        number = clock.tick(now)
        if number is not None:
            assert number > last
            assert -MS < now - number * 2 * MS < 2 * MS
            served, last = served + 1, number
    assert served + clock.missed == last + 1

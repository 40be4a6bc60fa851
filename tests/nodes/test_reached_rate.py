"""A replay tells the rate that it reaches, and not only the one it was asked for."""

import pytest

from ema_bench_replay.nodes.reached_rate import ReachedRate, rate_in_words

SECOND = 1_000_000_000


def test_what_is_reached_is_of_the_time_since_the_last_look():
    rate = ReachedRate(2e-3)
    assert rate.look(0, 0) is None
    assert rate.look(500, SECOND) == pytest.approx(1.0)
    assert rate.look(600, 2 * SECOND) == pytest.approx(0.2)
    rate.pause()
    assert rate.look(600, 50 * SECOND) is None


def test_a_rate_that_is_missed_is_told_beside_the_one_asked_for():
    assert rate_in_words(1.0, 0.2).startswith("0.2 × real time, 1 × was asked for")
    assert rate_in_words(1.0, 0.999) == rate_in_words(1.0, None) == "1 × real time"
    assert rate_in_words(0.0, 12.34) == "12.3 × real time, as fast as it goes"

"""Losses of a topic from the numbers that its publishers count on their own."""

import pytest

from ema_bench_replay.nodes.published_numbers import PublishedNumbers


@pytest.mark.parametrize(
    ("publishers", "numbers", "lost", "known"),
    [
        (1, [1, 2, 3], 0, True),
        (1, [40, 41, 42], 0, True),  # subscribed late
        (1, [1, 2, 6, 7], 3, True),
        (1, [7, 8, 1, 2], 0, True),  # the publisher started again
        (1, [7, 8, 1, 2, 4], 1, True),
        (2, [1, 50, 2, 51, 3], 0, False),
        (2, [1, 1, 2, 2, 10, 10], 0, False),
        (1, [1, None, 3], 0, False),  # a middleware that gives no numbers
    ],
)
def test_gaps_are_lost_and_new_publishers_are_not(publishers, numbers, lost, known):
    followed = PublishedNumbers(lambda: publishers)
    assert sum(map(followed.lost_before, numbers)) == lost
    assert followed.known == known

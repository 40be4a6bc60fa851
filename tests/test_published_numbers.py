"""Losses of a topic from the numbers that its publishers count on their own."""

import pytest

from ema_bench_replay.nodes.published_numbers import PublishedNumbers


@pytest.mark.parametrize(
    ("publishers", "numbers", "lost"),
    [
        (1, [1, 2, 3], 0),
        (1, [40, 41, 42], 0),  # subscribed late
        (1, [1, 2, 6, 7], 3),
        (1, [7, 8, 1, 2], 0),  # the publisher started again
        (1, [7, 8, 1, 2, 4], 1),
        (2, [1, 50, 2, 51, 3], 0),
        (2, [1, 50, 2, 53, 3, 54], 2),
        (2, [1, 50, 4, 51], 2),
    ],
)
def test_gaps_are_lost_and_new_publishers_are_not(publishers, numbers, lost):
    followed = PublishedNumbers(lambda: publishers)
    assert sum(map(followed.lost_before, numbers)) == lost

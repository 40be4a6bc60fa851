"""The time in which nothing arrives: a process that stands still does not count it."""

import pytest

from ema_twin_sim.live.idle_time import IdleTime


def test_it_grows_while_nothing_arrives_and_begins_anew_with_every_arrival():
    idle = IdleTime(longest_look=0.1)
    assert idle.look(5, 1000.0) == 0.0  # whatever the clock began with
    assert idle.look(5, 1000.05) == pytest.approx(0.05)
    assert idle.look(5, 1000.1) == pytest.approx(0.1)
    assert idle.look(6, 1000.15) == 0.0
    assert idle.look(6, 1000.2) == pytest.approx(0.05)


def test_a_process_that_stood_still_for_an_hour_has_waited_one_look():
    idle = IdleTime(longest_look=0.1)
    idle.look((1, 2), 0.0)
    assert idle.look((1, 2), 3600.0) == pytest.approx(0.1)

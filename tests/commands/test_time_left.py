"""The time left of many pieces of work, as it is told without a terminal."""

from types import SimpleNamespace

import pytest

from ema_twin_sim.commands import output


@pytest.fixture
def clock(monkeypatch):
    """A clock that a test sets; lines are told every 5 s of it."""
    held = SimpleNamespace(now=0.0)
    monkeypatch.setattr(output, "time", SimpleNamespace(monotonic=lambda: held.now))
    return held


def test_the_start_of_the_workers_does_not_count_as_work(clock, capsys):
    """The first of 600 recordings takes 13 s, the others 0.15 s each: no word of two hours."""
    with output.counted(600, "judging") as done:
        for k in range(600):
            clock.now = 13.0 + 0.15 * k
            done(f"{k}.csv")
    first, *others = capsys.readouterr().err.splitlines()
    assert first.startswith("13 s: judging: 1 of 600 done") and "left" not in first
    assert "left" not in others[0]
    told = [line for line in others if "left" in line]
    assert "about 75 s left" in told[0] and told == others[2:]


def test_within_one_long_piece_the_time_left_is_that_of_its_share(clock, capsys):
    with output.counted(1, "fitting") as done:
        for k in range(1, 10):
            clock.now = 10.0 * k
            done.within("a.csv", 0.1 * k)
    assert "20 s: fitting: 20 % of a.csv, about 80 s left" in capsys.readouterr().err

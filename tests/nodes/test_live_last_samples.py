"""A live run ends when its last sample was compared, however slow a node or quick the replay. No test here is timed."""

import time

import pytest

from ema_bench_replay.load import load
from ema_bench_replay.nodes.spin import steady_timer
from ema_twin_sim.live.follower import Follower
from ema_twin_sim.model import load_model
from ema_twin_sim.nodes import live, live_session
from ema_twin_sim.nodes.monitor import MonitorNode


@pytest.fixture
def short(traces):
    """0.4 s of a recording: the replay sends it in one burst."""
    return load(traces[0]).between(0.0, 0.4)


def ended(recording, **given):
    return live.run_live(recording, load_model("polito_bench"), rate=0.0, **given)


def with_patience(monkeypatch, seconds):
    for module in (live, live_session):
        monkeypatch.setattr(module, "PATIENCE", seconds)


def assert_whole(result, recording):
    assert result.complete
    assert result.counts["compared"] == result.counts["expected"] == result.samples == len(recording)
    assert result.counts["missing"] == 0


def test_a_replay_that_ends_before_the_first_look_around(short, monkeypatch):
    monkeypatch.setattr(live, "TICK", 3600.0)
    assert_whole(ended(short), short)


@pytest.mark.slow
@pytest.mark.parametrize(("patience", "each", "last"), [(0.2, 0.01, 0.01), (0.5, 0.0, 2.0)], ids=["all", "one call"])
def test_a_twin_that_takes_longer_than_the_patience(short, monkeypatch, patience, each, last):
    with_patience(monkeypatch, patience)
    answer = Follower.answer

    def slowly(self, run, sequence, *sample):
        time.sleep(last if sequence == len(short) - 1 else each)
        return answer(self, run, sequence, *sample)

    monkeypatch.setattr(Follower, "answer", slowly)
    assert_whole(ended(short), short)


def test_a_monitor_that_gets_its_answers_late(short, monkeypatch):
    with_patience(monkeypatch, 1.0)
    held = []
    on_twin = MonitorNode._on_twin
    monkeypatch.setattr(MonitorNode, "_on_twin", lambda self, message: held.append(message))

    def release(monitor):
        steady_timer(monitor, 0.02, lambda: on_twin(monitor, held.pop(0)) if held else None)

    assert_whole(ended(short, on_start=release), short)


def test_what_never_comes_ends_the_run_and_is_counted(short, monkeypatch):
    with_patience(monkeypatch, 0.3)
    on_twin, seen = MonitorNode._on_twin, []

    def deaf(self, message):
        seen.append(message)
        if len(seen) <= len(short) - 3:
            on_twin(self, message)

    monkeypatch.setattr(MonitorNode, "_on_twin", deaf)
    result = ended(short)
    assert not result.complete and result.counts["missing"] == 3 and result.samples == len(short) - 3

"""Workers that are gone for good: a campaign starts new ones, or ends and says why."""

import os
import signal
import threading
import time
from types import SimpleNamespace

import pytest

from ema_bench_replay.errors import InputError
from ema_twin_sim.campaign import engine, lost_workers
from ema_twin_sim.campaign.engine import cluster, run
from ema_twin_sim.campaign.jobs import Job
from ema_twin_sim.campaign.lost_workers import PATIENCE, LostWorkers
from ema_twin_sim.campaign.results import DONE
from tests.dask_cluster import lost, second_of_no_work

ADDRESS = "tcp://10.0.0.1:8786"


class _Others:
    """A client of a scheduler that others started, with so many workers; None: it does not answer."""

    cluster = None
    scheduler = SimpleNamespace(address=ADDRESS, ncores=None)

    def __init__(self):
        self.workers = 1
        self.asked = 0

    def sync(self, function, callback_timeout):
        self.asked += 1
        if self.workers is None:
            raise TimeoutError
        return dict.fromkeys(range(self.workers), 1)


@pytest.fixture
def others():
    return _Others()


def _looks(watch, clock, seconds):
    """Look every half second for a time."""
    for _ in range(round(2 * seconds)):
        clock[0] += 0.5
        watch.look()


class TestOthersWorkers:
    def test_a_campaign_without_workers_ends_with_a_remedy(self, others, caplog):
        clock = [0.0]
        watch = LostWorkers(others, lambda: clock[0])
        others.workers = 0
        _looks(watch, clock, PATIENCE - 2.0)
        (told,) = caplog.records
        assert f"dask worker {ADDRESS}" in told.getMessage() and "10 min at most" in told.getMessage()
        with pytest.raises(InputError, match=f"has had no workers for 10 min; .*dask worker {ADDRESS}.* are kept"):
            _looks(watch, clock, 4.0)

    def test_a_scheduler_that_does_not_answer_is_told_from_one_without_workers(self, others):
        clock = [0.0]
        watch = LostWorkers(others, lambda: clock[0])
        others.workers = None
        with pytest.raises(InputError, match=f"--scheduler {ADDRESS}: has not answered for 10 min; end it"):
            _looks(watch, clock, 1.1 * PATIENCE)

    def test_workers_that_come_back_in_time_end_nothing(self, others, caplog):
        """Each time that they are missing is told once."""
        clock = [0.0]
        watch = LostWorkers(others, lambda: clock[0])
        for others.workers in (0, 1, 0, 3, 0):
            _looks(watch, clock, 0.9 * PATIENCE)
        assert ["has had no workers" in record.getMessage() for record in caplog.records] == [True] * 3

    def test_the_scheduler_is_not_asked_at_every_batch(self, others):
        clock = [0.0]
        watch = LostWorkers(others, lambda: clock[0])
        for _ in range(1000):
            clock[0] += 0.01
            watch.look()
        assert others.asked <= 10


def _jobs(number):
    return [Job(str(k), "A", str(k), ()) for k in range(number)]


def _give_up(local):
    """End all workers for good, as dask does with one whose connection broke."""
    nannies = [*local.workers.values()]
    for nanny in nannies:
        local.sync(nanny.close)
    return nannies


@pytest.mark.slow
class TestOwnWorkers:
    def test_workers_that_were_given_up_are_replaced(self, client):
        """Whether dask still lists them or not."""
        local = client.cluster
        first = _give_up(local)
        del local.workers[0]
        assert [outcome.status for outcome in run(client, _jobs(4), second_of_no_work, lost)] == [DONE] * 4
        client.wait_for_workers(2)
        assert len(local.workers) == 2 and not {*first} & {*local.workers.values()}

    def test_a_worker_may_take_its_time_to_return(self, client):
        """By default dask gives it 15 s, which a start on a busy machine exceeds."""
        import dask

        assert dask.config.get("distributed.deploy.lost-worker-timeout") == f"{PATIENCE} s"

    def test_a_campaign_whose_workers_cannot_start_ends(self, client, monkeypatch):
        """And says so; then, once they can, the next one finds workers again."""
        import dask

        monkeypatch.setattr(lost_workers, "PATIENCE", 2.0)
        with dask.config.set({"distributed.worker.preload": ["no_such_module"]}):
            _give_up(client.cluster)
            with pytest.raises(InputError, match="--workers 2: no worker process has been running") as told:
                list(run(client, _jobs(4), second_of_no_work, lost))
            assert "run the command again" in str(told.value)
        monkeypatch.undo()
        assert [outcome.status for outcome in run(client, _jobs(4), second_of_no_work, lost)] == [DONE] * 4


@pytest.mark.slow
def test_workers_that_do_not_start_are_told():
    import dask

    with (
        dask.config.set({"distributed.worker.preload": ["no_such_module"]}),
        pytest.raises(InputError, match=r"--workers 1: .* do not start .*no_such_module.*; free memory"),
        cluster(None, 1),
    ):
        pass


@pytest.mark.slow
def test_a_process_that_does_not_end_does_not_keep_the_campaign(monkeypatch):
    """Such as one that waits for a disk: here, one that was stopped while it started."""
    monkeypatch.setattr(engine, "_ENDING", 1.0)
    with cluster(None, 1) as client:
        (nanny,) = client.cluster.workers.values()
        first = nanny.pid
        os.kill(first, signal.SIGKILL)
        while (stopped := nanny.pid) in (None, first):
            time.sleep(0.01)
        os.kill(stopped, signal.SIGSTOP)
        let_go = threading.Timer(120.0, os.kill, (stopped, signal.SIGKILL))
        let_go.start()
    ended_by_itself = let_go.is_alive()
    let_go.cancel()
    os.kill(stopped, signal.SIGKILL)
    assert ended_by_itself

"""A campaign's workers: what becomes of lost ones, and of a campaign that is killed."""

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from contextlib import suppress
from functools import partial
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from ema_bench_replay.errors import InputError
from ema_twin_sim.campaign.campaign import campaign
from ema_twin_sim.campaign.engine import SPARING, Outcome, cluster, run
from ema_twin_sim.campaign.jobs import Grouping, Job, Task, find_jobs
from ema_twin_sim.campaign.results import DONE, FAILED, REFUSED
from ema_twin_sim.campaign.store import Store
from ema_twin_sim.campaign.units import units_of
from tests.command_line import done_here, twin
from tests.conftest import RECORDINGS
from tests.dask_cluster import lost, own_cluster

MANY = 24
COMPARE = Task("compare", "polito_bench")


def _stub(jobs, folder):
    """Work that takes no time; "kill" ends its worker, the first time or always."""
    for job in jobs:
        if job.name.startswith("kill"):
            once = Path(folder) / job.name
            if job.name == "kill always" or not once.exists():
                once.touch()
                os.kill(os.getpid(), signal.SIGKILL)
    return [Outcome(job, DONE, "", 1e-4) for job in jobs]


def _settings(names):
    import dask

    return [dask.config.get(name) for name in names]


class TestEngine:
    @pytest.mark.slow
    def test_every_job_is_done_once(self, client, tmp_path):
        jobs = [Job(str(k), "A", str(k), ()) for k in range(2000)]
        outcomes = list(run(client, iter(jobs), partial(_stub, folder=str(tmp_path)), lost))
        assert sorted(int(outcome.job.key) for outcome in outcomes) == [*range(2000)]

    @pytest.mark.slow
    def test_a_worker_that_dies_takes_no_job_with_it(self, client, tmp_path):
        names = [*(str(k) for k in range(40)), "kill once", "kill always", *(str(k) for k in range(40, 80))]
        jobs = [Job(name, "A", name, ()) for name in names]
        outcomes = {o.job.name: o for o in run(client, jobs, partial(_stub, folder=str(tmp_path)), lost)}
        assert {*outcomes} == {*names}
        assert [name for name, outcome in outcomes.items() if outcome.status == FAILED] == ["kill always"]
        assert "died" in outcomes["kill always"].message

    @pytest.mark.slow
    def test_it_listens_to_this_campaign_only(self, client):
        assert client.scheduler.address.startswith("tls://127.0.0.1:")
        assert all(address.startswith("tls://127.0.0.1:") for address in client.nthreads())

    @pytest.mark.slow
    def test_no_process_watches_itself(self, client):
        told = client.run(_settings, [*SPARING])
        assert len(told) == 2 and all(settings == [*SPARING.values()] for settings in told.values())

    @pytest.mark.slow
    def test_a_campaign_fills_a_store(self, client, folder, tmp_path):
        store = Store.made(tmp_path / "r")
        jobs = find_jobs(Grouping.of(folder, None, "recording"), COMPARE)
        statuses = [outcome.status for outcome in campaign(client, jobs, COMPARE, store.folder)]
        assert sorted(statuses) == [DONE, DONE, DONE, REFUSED]
        assert store.settled() == {job.key for job in jobs}
        first, second = units_of(store.rows())
        assert "is a copy of" not in "".join((*first.remarks, *second.remarks))  # other units may share a recording


@pytest.mark.slow
def test_no_scheduler_is_told():
    with pytest.raises(InputError, match="does not answer"), cluster("tcp://127.0.0.1:1", 1):
        pass


def _command(*arguments, **options):
    """A process of its own group, so that it can be killed with nothing else."""
    start = "import sys; sys.argv[0] = 'ema-twin'; from ema_twin_sim.entry import main; main()"
    return subprocess.Popen(
        [sys.executable, "-c", start, "campaign", *map(str, arguments)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True, **options,
    )  # fmt: skip


def _until(is_so, seconds=120.0):
    begun = time.monotonic()
    while not is_so():
        assert time.monotonic() - begun < seconds
        time.sleep(0.05)


def _many_recordings(folder):
    """Arguments of a campaign that compares the same recording as MANY of four units."""
    recording = sorted(RECORDINGS.glob("*.CSV"))[0]
    for k in range(MANY):
        unit = folder / "runs" / f"U{k % 4}"
        unit.mkdir(parents=True, exist_ok=True)
        shutil.copy(recording, unit / f"{k}.CSV")
    return folder / "runs", "--model", "polito_bench", "-o", folder / "r", "--do", "compare"


@pytest.mark.slow
def test_a_campaign_that_was_killed_goes_on_where_it_was(tmp_path, capsys):
    asked = (*_many_recordings(tmp_path), "--workers", 1)
    first = _command(*asked)
    _until(lambda: len([*tmp_path.rglob("*.parquet")]) >= 5)
    first.kill()  # the campaign alone: its workers see that it is gone
    first.wait()
    done = Store(tmp_path / "r").settled()
    assert 5 <= len(done) < MANY
    done_here("campaign", *asked)
    told = capsys.readouterr().out
    again = int(re.search(rf"(\d+) of {MANY} already have results", told)[1])
    assert again >= len(done)
    assert f"{MANY - again} judged" in told
    files = [row for file in tmp_path.rglob("*.parquet") for row in pq.read_table(file)["key"].to_pylist()]
    assert len(files) == len({*files}) == MANY
    assert not [*tmp_path.rglob("*.part")]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A cluster of which nothing is killed: what was begun on others is ended on it."""
    with own_cluster(tmp_path_factory.mktemp("whole")) as own:
        yield own


@pytest.mark.slow
@pytest.mark.parametrize("victim", ["worker", "scheduler", "client"])
def test_whatever_is_killed_at_half_time_the_table_is_the_same(victim, whole, tmp_path, capsys):
    """A cluster of others' making: of its processes one is killed, and the campaign is started again where it ended."""
    asked = (*_many_recordings(tmp_path), "--scheduler")
    with own_cluster(tmp_path / "first", workers=2 if victim == "worker" else 1) as own:
        first = _command(*asked, own.address)
        _until(lambda: len(_keys(tmp_path)) >= 8)
        {"worker": own.workers[0], "scheduler": own.scheduler, "client": first}[victim].kill()
        at = len(_keys(tmp_path))
        told, errors = first.communicate(timeout=300)
        if victim == "worker":
            assert first.returncode == 0 and f"{MANY} judged" in told, errors
        elif victim == "scheduler":
            assert first.returncode == 2, errors
            assert errors.strip().splitlines()[-1].startswith("error: the scheduler has ended")
            for worker in own.workers:
                worker.wait(timeout=120)  # with its scheduler
        else:
            _until(lambda: not _at_work(own.address))  # what it had given out is done, or given up
    done = Store(tmp_path / "r").settled()
    done_here("campaign", *asked, whole.address)
    again = re.search(rf"(\d+) of {MANY} already have results", capsys.readouterr().out)
    assert again and int(again[1]) == len(done) >= at
    keys = _keys(tmp_path)
    rows = Store(tmp_path / "r").rows()
    with capsys.disabled():
        print(
            f"\n  {victim} killed after {at} of {MANY}: {len(keys) - len({*keys})} done twice, {MANY - len(rows)} lost",
            end="",
        )
    assert len(keys) == len({*keys}) == len(rows) == MANY
    assert {row["status"] for row in rows} == {DONE}
    assert len({str(row["errors"]) for row in rows}) == 1  # of all copies: that of a campaign that nobody disturbed
    assert not [*tmp_path.rglob("*.part")]


@pytest.mark.slow
def test_a_campaign_that_judges_nothing_ends_as_refused_input_does(tmp_path):
    folder = tmp_path / "runs"
    folder.mkdir()
    (folder / "torn.csv").write_text("time [s],current [A]\n0,1\n")
    ended = twin("campaign", folder, "--model", "polito_bench", "-o", tmp_path / "r", "--workers", "1")
    assert ended.returncode == 2 and "0 judged, 1 refused." in ended.stdout
    assert "Traceback" not in ended.stderr


def _keys(folder):
    """The key of every row in the store, as often as it stands there."""
    keys = []
    for file in folder.rglob("*.parquet"):
        with suppress(FileNotFoundError):  # made one with others
            keys += pq.read_table(file)["key"].to_pylist()
    return keys


def _at_work(address):
    """How many tasks a scheduler has."""
    from distributed import Client

    with Client(address) as client:
        return sum(len(tasks) for tasks in client.processing().values())


@pytest.mark.slow
@pytest.mark.parametrize("at_work", [False, True])
def test_ctrl_c_in_a_terminal_ends_a_campaign_without_tracebacks(tmp_path, at_work):
    """A terminal interrupts all processes of a command: those that are starting, and those that work."""
    for number in range(12):
        shutil.copytree(RECORDINGS, tmp_path / "runs" / f"unit {number}")
    with _command(
        tmp_path / "runs", "--model", "polito_bench", "-o", tmp_path / "results", "--workers", "2", "--do", "compare",
        preexec_fn=partial(signal.signal, signal.SIGINT, signal.SIG_DFL),  # a shell's background ignores it
    ) as process:  # fmt: skip
        if at_work:
            _until(lambda: [*tmp_path.rglob("*.parquet")])
        else:
            time.sleep(1.5)
        os.killpg(process.pid, signal.SIGINT)
        printed = process.communicate(timeout=60.0)
    assert process.returncode == 130
    assert "Traceback" not in "".join(printed)

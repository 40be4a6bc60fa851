"""What a campaign costs beside its work: of a thousand recordings, of 10⁵ jobs that do nothing, of as many results.

Scheduler and workers are processes of their own, so that what each takes is told apart. Shown are seconds of a
processor, which a busy machine hardly moves, and seconds of the clock, which it does. EMA_BENCH_RECORDINGS makes it
fewer.
"""

import math
import os
import shutil
import time
from datetime import datetime, timedelta, timezone

import psutil
import pytest

from ema_bench_replay.bags.bag_writer import write_mcap
from ema_twin_sim.campaign.campaign import campaign
from ema_twin_sim.campaign.engine import cluster, run
from ema_twin_sim.campaign.jobs import Grouping, Job, Task, find_jobs
from ema_twin_sim.campaign.results import DONE, SCHEMA
from ema_twin_sim.campaign.store import Store
from ema_twin_sim.model import load_model
from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.virtual_bench import virtual_bench
from tests.accuracy.commands import Drive
from tests.accuracy.machine import stock_machine
from tests.accuracy.other_bench import OtherBench
from tests.accuracy.unkind import Unkind
from tests.benchmarks.timing import processor_time
from tests.dask_cluster import lost, no_work, own_cluster, second_of_no_work

OVERVIEW = """
    SELECT unit, count(*), max(time), max(list_max(list_transform(beyond_noise, lambda signal: signal.times))),
           sum(list_contains(missing, 'backlash')::INT)
    FROM results GROUP BY unit ORDER BY 4 DESC
"""
OVERVIEW_TIME = 1.0  # s of a processor
UNITS, EACH = 1000, 100
RECORDINGS = int(os.environ.get("EMA_BENCH_RECORDINGS", "1000"))
SECONDS = 20.0  # of each recording
STUBS = 100_000
COMPARE = Task("compare", "polito_bench")
OVERHEAD = 1e-3  # s of a processor that a job which does nothing may take, of all processes together
SCALING = 0.9  # of the workers' own time
GROWTH = 60.0  # MiB, of a worker from a tenth of the recordings on


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Recordings of the virtual bench and of another program's plant by turns, in ten units."""
    folder = tmp_path_factory.mktemp("campaign")
    write_mcap(virtual_bench(load_model("polito_bench"), parse_command("triangle:0.1:0.5"), SECONDS), folder / "0.mcap")
    write_mcap(OtherBench(stock_machine(), (), Unkind(), seed=3).record(Drive("triangle", 0.1, 0.5), SECONDS),
               folder / "1.mcap")  # fmt: skip
    for k in range(RECORDINGS):
        unit = folder / "runs" / f"U{k // 2 % 10}"
        unit.mkdir(parents=True, exist_ok=True)
        shutil.copy(folder / f"{k % 2}.mcap", unit / f"{k}.mcap")
    return folder


def measured(folder, workers):
    """A campaign over all recordings: seconds of processors and of the clock from the second tenth on, and memory."""
    store = Store.made(folder / f"results of {workers}")
    jobs = find_jobs(Grouping.of(folder / "runs", None, "recording"), COMPARE)
    with own_cluster(folder / f"cluster of {workers}", workers) as own, cluster(own.address, workers) as client:
        client.wait_for_workers(workers)
        every = (own.scheduler, *own.workers)
        begun, first, memory, warm = time.perf_counter(), None, [], None
        for number, outcome in enumerate(campaign(client, jobs, COMPARE, store.folder)):
            assert outcome.status == DONE, outcome.message
            first = first or time.perf_counter() - begun
            if number == len(jobs) // 10:  # each worker has imported all that it needs
                warm = time.perf_counter(), time.process_time(), [*map(processor_time, every)]
            if number in (len(jobs) // 10, len(jobs) - 1):
                memory.append(max(psutil.Process(p.pid).memory_info().rss for p in own.workers) / 2**20)
        clock = time.perf_counter() - warm[0]
        client_time = time.process_time() - warm[1]
        scheduler, *of_workers = (now - was for now, was in zip(map(processor_time, every), warm[2], strict=True))
    assert len(store.settled()) == len(jobs)
    return {
        "first": first,
        "clock": clock,
        "workers": sum(of_workers),
        "scheduler": scheduler,
        "client": client_time,
        "memory": memory,
    }


@pytest.mark.timeout(3600)
def test_recordings_cost_the_same_with_two_workers(folder, say):
    one, two = (measured(folder, workers) for workers in (1, 2))
    counted = RECORDINGS - RECORDINGS // 10
    for workers, of in ((1, one), (2, two)):
        say(
            f"\n  {counted} recordings, {workers} worker(s): {of['clock']:.0f} s, {counted / of['clock']:.1f}/s; "
            f"of a processor: workers {of['workers']:.1f} s, scheduler {of['scheduler']:.1f} s, "
            f"client {of['client']:.1f} s; first result after {of['first']:.1f} s; "
            f"memory of a worker {of['memory'][0]:.0f} to {of['memory'][-1]:.0f} MiB"
        )
    say(f"\n  scaling of the workers' own time: {one['workers'] / two['workers']:.0%}")
    assert one["workers"] / two["workers"] >= SCALING
    assert max(of["memory"][-1] - of["memory"][0] for of in (one, two)) <= GROWTH


@pytest.mark.timeout(1800)
@pytest.mark.parametrize("work", [no_work, second_of_no_work], ids=["a thousand a task", "one a task"])
def test_what_a_job_costs_that_does_nothing(work, tmp_path, say):
    number = STUBS if work is no_work else STUBS // 10
    jobs = [Job(str(k), "A", str(k), ()) for k in range(number)]
    with own_cluster(tmp_path / "cluster") as own, cluster(own.address, 1) as client:
        client.wait_for_workers(1)
        every = (own.scheduler, *own.workers)
        client.submit(sum, [1]).result()
        before, own_before = [*map(processor_time, every)], time.process_time()
        begun = time.perf_counter()
        outcomes = run(client, iter(jobs), work, lost)
        next(outcomes)
        first = time.perf_counter() - begun
        assert sum(1 for _ in outcomes) == number - 1
        clock = time.perf_counter() - begun
        scheduler, worker = (now - was for now, was in zip(map(processor_time, every), before, strict=True))
        client_time = time.process_time() - own_before
    say(
        f"\n  {number} jobs: first after {first:.2f} s, all after {clock:.1f} s; of a processor, a job: scheduler "
        f"{1e6 * scheduler / number:.0f} us, client {1e6 * client_time / number:.0f} us, worker "
        f"{1e6 * worker / number:.0f} us"
    )
    if work is no_work:
        assert (scheduler + client_time + worker) / number <= OVERHEAD


def test_an_overview_of_a_hundred_thousand_results(tmp_path, say):
    store = Store.made(tmp_path / "results")
    begun = datetime(2026, 1, 1, tzinfo=timezone.utc)
    for unit in range(UNITS):
        store.write(
            [
                {
                    **dict.fromkeys(SCHEMA.names),
                    **{"key": f"{unit} {k}", "unit": f"EMA-{unit:04}", "name": f"week {k}", "task": "discover"},
                    **{"model": "m", "status": DONE, "time": begun + timedelta(weeks=k), "done_at": begun},
                    **{"verdict": "explained", "missing": ["backlash"] if k % 3 else []},
                    "beyond_noise": [{"signal": "current", "times": 1.0 + k}],
                    "parameters": [{"owner": "backlash", "name": "width", "value": 2e-3, "std": 1e-5, "unit": "rad"}],
                }
                for k in range(EACH)
            ]
        )
    taken_best, clock = math.inf, math.inf
    for _ in range(3):
        own, begun_at = time.process_time(), time.perf_counter()
        with store.query() as database:
            units = database.sql(OVERVIEW).fetchall()
        taken_best = min(taken_best, time.process_time() - own)
        clock = min(clock, time.perf_counter() - begun_at)
    assert len(units) == UNITS and all(count == EACH for _, count, *_ in units)
    say(f"\n  overview of {UNITS * EACH} results: {taken_best:.2f} s of a processor, {clock:.2f} s of the clock")
    assert taken_best <= OVERVIEW_TIME

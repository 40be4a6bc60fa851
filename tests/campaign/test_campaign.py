"""What a campaign judges: each recording of each unit once, as the command judges it."""

from pathlib import Path

import pytest

from ema_bench_replay.bags.stream_writer import StreamWriter
from ema_bench_replay.errors import InputError
from ema_twin_sim.campaign.jobs import Grouping, Task, find_jobs
from ema_twin_sim.campaign.results import DONE, FAILED, REFUSED
from ema_twin_sim.campaign.work import judged

COMPARE = Task("compare", "polito_bench")


class TestJobs:
    def test_a_unit_is_a_folder(self, folder):
        jobs = find_jobs(Grouping.of(folder, None, "recording"), COMPARE)
        assert [(job.unit, Path(job.name).suffix) for job in jobs] == [("A", ".CSV")] * 2 + [("B", ".CSV")] * 2

    def test_a_pattern_tells_unit_and_time(self, tmp_path):
        for name in ("EMA7_2026-03-01.csv", "EMA8_2026-03-02.csv", "notes.csv"):
            (tmp_path / name).write_text("a\n")
        told = []
        pattern = r"(?P<unit>EMA\d+)_(?P<time>[\d-]+)"
        jobs = find_jobs(Grouping.of(tmp_path, pattern, "unit"), COMPARE, tell=told.append)
        assert [(job.unit, job.time.day) for job in jobs] == [("EMA7", 1), ("EMA8", 2)]
        assert "notes.csv" in told[0]

    def test_a_time_that_is_none_leaves_one_recording_out(self, tmp_path):
        for name in ("EMA7_2026-03-01.csv", "EMA7_2026-13-01.csv", "EMA8_2026-03-02.csv"):
            (tmp_path / name).write_text("a\n")
        told = []
        pattern = r"(?P<unit>EMA\d+)_(?P<time>[\d-]+)"
        jobs = find_jobs(Grouping.of(tmp_path, pattern, "recording"), COMPARE, tell=told.append)
        assert [job.name for job in jobs] == ["EMA7_2026-03-01.csv", "EMA8_2026-03-02.csv"]
        (one,) = told
        assert "EMA7_2026-13-01.csv: 2026-13-01 is no time" in one and one.endswith("left out")

    @pytest.mark.parametrize(
        ("pattern", "reason"), [("(", "no regular"), ("EMA", "a group"), ("(?P<unit>.)(?P<day>.)", "a group")]
    )
    def test_a_pattern_without_a_unit_is_refused(self, tmp_path, pattern, reason):
        with pytest.raises(InputError, match=reason):
            Grouping.of(tmp_path, pattern, "recording")

    def test_a_recording_that_changes_is_another_job(self, folder):
        grouping = Grouping.of(folder, None, "recording")
        before = {job.name: job.key for job in find_jobs(grouping, COMPARE)}
        changed = folder / "B" / "torn.CSV"
        changed.write_text("time;current\n0;0\n")
        after = {job.name: job.key for job in find_jobs(grouping, COMPARE)}
        assert {name for name in before if before[name] != after[name]} == {"B/torn.CSV"}
        assert not {*after.values()} & {job.key for job in find_jobs(grouping, Task("fit", "polito_bench"))}

    def test_a_recording_that_was_split_is_one(self, tmp_path):
        writer = StreamWriter(tmp_path / "A" / "run", max_size=1)
        writer.add_topic("/t", "std_msgs/msg/Empty", "")
        for moment in (1, 2):
            writer.write("/t", b"", moment, moment)
            writer.flush()
        writer.finish()
        (tmp_path / "A" / "run" / "metadata.yaml").unlink()  # as where it was killed
        (job,) = find_jobs(Grouping.of(tmp_path, None, "recording"), COMPARE)
        assert [Path(part).name for part in job.recordings[0]] == ["run.mcap", "run_1.mcap"]

    def test_results_beneath_the_folder_are_no_recordings(self, folder):
        (folder / "results").mkdir()
        (folder / "results" / "copy.csv").write_text("a\n")
        grouping = Grouping.of(folder, None, "folder")
        assert [job.unit for job in find_jobs(grouping, COMPARE, (folder / "results",))] == ["A", "B"]


class TestWork:
    def test_a_recording_is_judged_as_the_command_judges_it(self, folder):
        from ema_bench_replay.load import load
        from ema_twin_sim.comparison.compare import compare
        from ema_twin_sim.model import load_model

        job = find_jobs(Grouping.of(folder, None, "recording"), COMPARE)[0]
        row = judged(job, COMPARE)[0]
        overall = compare([load(job.recordings[0][0])], load_model("polito_bench")).overall
        assert {e["signal"]: e["rmse"] for e in row["errors"]} == {
            name: error["rmse"] for name, error in overall.items() if not error["driven"]
        }
        assert (row["status"], row["unit"], row["motion"]) == (DONE, "A", "rotary")

    def test_what_cannot_be_judged_has_a_row(self, folder, monkeypatch):
        jobs = find_jobs(Grouping.of(folder, None, "recording"), COMPARE)
        torn = judged(jobs[-1], COMPARE)[0]
        assert torn["status"] == REFUSED
        assert "torn.CSV" in torn["message"]
        monkeypatch.setattr("ema_twin_sim.campaign.work._of_recordings", lambda recordings: 1 / 0)
        broken = judged(jobs[0], COMPARE)[0]
        assert (broken["status"], "ZeroDivisionError" in broken["message"]) == (FAILED, True)
<<<<<<< HEAD
=======


class TestUnits:
    def test_what_does_not_go_together_is_named(self):
        of = {"motion": "rotary", "signals": ["current"], "content": ["x"], "errors": []}
        others = {"time": None, "duration": 1.0, "missing": [], "verdict": None}
        rows = [a_row(**of, **others), a_row(name="b", **{**of, "motion": "linear", "signals": ["speed"]}, **others)]
        (unit,) = units_of(rows)
        told = "\n".join(unit.remarks)
        for part in ("linear and rotary machines", "differ in what they hold", "b is a copy of a", "one recording"):
            assert part in told

    def test_clocks_that_disagree_are_named(self):
        of = {"motion": "rotary", "signals": [], "errors": [], "duration": 10.0}
        at = partial(datetime.fromtimestamp, tz=timezone.utc)
        rows = [
            a_row(name=name, time=at(second), content=[name], **of) for name, second in (("a", 0), ("b", 20), ("c", 25))
        ]
        (unit,) = units_of(rows)
        assert unit.remarks == ("c begins before b ends: one of their clocks is wrong",)

    def test_the_worst_in_its_last_recording_comes_first(self):
        rows = [
            a_row(unit=unit, errors=[], beyond_noise=[{"signal": "current", "times": times}])
            for unit, times in (("A", 2.0), ("B", 7.0))
        ]
        assert [(unit.name, unit.beyond_noise) for unit in units_of(rows)] == [("B", 7.0), ("A", 2.0)]


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


def _lost(job, reason):
    return Outcome(job, FAILED, reason, 0.0)


@pytest.fixture(scope="module")
def client():
    with cluster(None, 2) as client:
        yield client


class TestEngine:
    @pytest.mark.slow
    def test_every_job_is_done_once(self, client, tmp_path):
        jobs = [Job(str(k), "A", str(k), ()) for k in range(2000)]
        outcomes = list(run(client, iter(jobs), partial(_stub, folder=str(tmp_path)), _lost))
        assert sorted(int(outcome.job.key) for outcome in outcomes) == [*range(2000)]

    @pytest.mark.slow
    def test_a_worker_that_dies_takes_no_job_with_it(self, client, tmp_path):
        names = [*(str(k) for k in range(40)), "kill once", "kill always", *(str(k) for k in range(40, 80))]
        jobs = [Job(name, "A", name, ()) for name in names]
        outcomes = {o.job.name: o for o in run(client, jobs, partial(_stub, folder=str(tmp_path)), _lost)}
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


def _command(*arguments):
    """A process of its own group, so that it can be killed with nothing else."""
    start = "import sys; sys.argv[0] = 'ema-twin'; from ema_twin_sim.entry import main; main()"
    return subprocess.Popen(
        [sys.executable, "-c", start, "campaign", *map(str, arguments)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip


def _until(is_so, seconds=120.0):
    begun = time.monotonic()
    while not is_so():
        assert time.monotonic() - begun < seconds
        time.sleep(0.05)


def _forty_recordings(folder):
    """Arguments of a campaign that compares the same recording as forty of four units."""
    recording = sorted(RECORDINGS.glob("*.CSV"))[0]
    for k in range(40):
        unit = folder / "runs" / f"U{k % 4}"
        unit.mkdir(parents=True, exist_ok=True)
        shutil.copy(recording, unit / f"{k}.CSV")
    return folder / "runs", "--model", "polito_bench", "-o", folder / "r", "--do", "compare"


@pytest.mark.slow
def test_a_campaign_that_was_killed_goes_on_where_it_was(tmp_path):
    asked = (*_forty_recordings(tmp_path), "--workers", 2)
    first = _command(*asked)
    _until(lambda: len([*tmp_path.rglob("*.parquet")]) >= 5)
    first.kill()  # the campaign alone: its workers see that it is gone
    first.wait()
    done = Store(tmp_path / "r").settled()
    assert 5 <= len(done) < 40
    second = _command(*asked)
    told, errors = second.communicate(timeout=300)
    assert second.returncode == 0, errors
    again = int(re.search(r"(\d+) of 40 are judged already", told)[1])
    assert again >= len(done)
    assert f"{40 - again} judged" in told
    files = [row for file in tmp_path.rglob("*.parquet") for row in pq.read_table(file)["key"].to_pylist()]
    assert len(files) == len({*files}) == 40
    assert not [*tmp_path.rglob("*.part")]


@pytest.mark.slow
@pytest.mark.parametrize("victim", ["worker", "scheduler", "client"])
def test_whatever_is_killed_at_half_time_the_table_is_the_same(victim, tmp_path, capsys):
    """A cluster of others' making: of its processes one is killed, and the campaign is started again where it ended."""
    asked = (*_forty_recordings(tmp_path), "--scheduler")
    with own_cluster(tmp_path / "first", workers=2) as own:
        first = _command(*asked, own.address)
        _until(lambda: len(_keys(tmp_path)) >= 15)
        {"worker": own.workers[0], "scheduler": own.scheduler, "client": first}[victim].kill()
        at = len(_keys(tmp_path))
        told, errors = first.communicate(timeout=300)
        if victim == "worker":
            assert first.returncode == 0 and "40 judged" in told, errors
        elif victim == "scheduler":
            assert first.returncode == 2, errors
            assert errors.strip().splitlines()[-1].startswith("error: the scheduler is gone")
            for worker in own.workers:
                worker.wait(timeout=120)  # with its scheduler
        else:
            _until(lambda: not _at_work(own.address))  # what it had given out is done, or given up
    done = Store(tmp_path / "r").settled()
    with own_cluster(tmp_path / "second", workers=2) as own:
        told, errors = _command(*asked, own.address).communicate(timeout=300)
    again = re.search(r"(\d+) of 40 are judged already", told)
    assert again and int(again[1]) == len(done) >= at, errors
    keys = _keys(tmp_path)
    rows = Store(tmp_path / "r").rows()
    with capsys.disabled():
        print(
            f"\n  {victim} killed after {at} of 40: {len(keys) - len({*keys})} done twice, {40 - len(rows)} lost",
            end="",
        )
    assert len(keys) == len({*keys}) == len(rows) == 40
    assert {row["status"] for row in rows} == {DONE}
    assert len({str(row["errors"]) for row in rows}) == 1  # of forty copies: that of a campaign that nobody disturbed
    assert not [*tmp_path.rglob("*.part")]


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


class TestHistories:
    @staticmethod
    def a_unit(values, std=1.0, dated=True):
        at = partial(datetime.fromtimestamp, tz=timezone.utc)
        rows = [
            a_row(
                name=f"week {k}",
                key=str(k),
                duration=20.0,
                time=at(k * 7 * 86400.0) if dated else None,
                parameters=[{"owner": "backlash", "name": "width", "value": value, "std": std, "unit": "rad"}],
            )
            for k, value in enumerate(values)
        ]
        return units_of(rows)[0]

    def test_a_number_that_stays_has_no_change_and_no_trend(self):
        values = 100.0 + np.random.default_rng(3).normal(size=30)
        (look,) = outlooks(self.a_unit(values), {"backlash.width": 120.0})
        assert (look.change, look.trend, look.life) == (None, None, None)
        assert look.margin.share == pytest.approx(1.0, abs=0.05)

    def test_wear_is_told_with_its_begin_and_when_it_reaches_its_limit(self):
        wear = np.maximum(0.0, np.arange(40) - 20.0)  # one a week from week 20 on
        values = 100.0 + wear + np.random.default_rng(4).normal(size=40)
        (look,) = outlooks(self.a_unit(values), {"backlash.width": 130.0}, healthy=Healthy(15))
        assert 19 <= look.change.begin <= 26
        assert look.trend.slope * 7.0 == pytest.approx(1.0, rel=0.15)  # days
        assert look.life.earliest < 11 * 7.0 < look.life.latest  # 19 of 30 are gone

    def test_healthy_ones_by_a_pattern_count_wherever_they_are(self):
        """Recordings of a spare that stood in for some weeks are no baseline, and those after it are one again."""
        values = 100.0 + np.random.default_rng(7).normal(size=40)
        values[4:12] += 30.0
        healthy = Healthy.of("week ([0-3]|1[2-9]|2.|3.)$", 4)
        (look,) = outlooks(self.a_unit(values), {}, healthy=healthy)
        assert look.healthy == pytest.approx(100.0, abs=0.6) and look.history.healthy.sum() == 32
        assert (look.history.names[look.change.begin], look.history.names[look.change.alarm]) == ("week 4", "week 4")
        assert look.change.size == pytest.approx(30.0, abs=2.0) and look.history.as_asked

    def test_too_few_healthy_ones_by_a_pattern_are_told(self):
        (look,) = outlooks(self.a_unit(100.0 + np.arange(30.0)), {}, healthy=Healthy.of("week 29", 4))
        assert not look.history.as_asked and look.history.healthy.tolist() == [True] * 10 + [False] * 20

    def test_a_day_is_healthy_where_all_its_results_are(self):
        unit = self.a_unit(100.0 + np.random.default_rng(8).normal(size=40))
        rows = [{**row, "time": datetime.fromtimestamp((k // 2) * 7 * 86400.0 + 60.0 * (k % 2), timezone.utc)}
                for k, row in enumerate(unit.rows)]  # fmt: skip
        (look,) = outlooks(units_of(rows)[0], {}, healthy=Healthy(11))
        assert look.history.healthy.tolist() == [True] * 5 + [False] * 15

    def test_what_all_recordings_share_hides_no_change(self):
        """A constant that is known to 10 % makes every value as uncertain, and no week unlike another."""
        values = 100.0 + np.random.default_rng(5).normal(size=40)
        values[25:] += 8.0
        (look,) = outlooks(self.a_unit(values, std=10.0), {}, healthy=Healthy(20))
        assert look.change.begin == 25
        assert look.share == pytest.approx(0.08, abs=0.02)

    def test_what_all_recordings_share_delays_no_change(self):
        """A torque constant beside an inertia that is known to 3 %: each test repeats it to 0.3 %."""
        values = 100.0 + np.random.default_rng(9).normal(size=24)
        values[15:] += 10.0
        (look,) = outlooks(self.a_unit(values, std=10.0), {}, healthy=Healthy(12))
        assert (look.change.begin, look.change.alarm) == (15, 15)

    def test_healthy_units_seldom_seem_to_change(self):
        drawn = np.random.default_rng(6)
        units = [self.a_unit(100.0 + drawn.normal(size=30), std=std) for std in (1.0, 10.0) for _ in range(40)]
        assert sum(outlooks(unit, {})[0].change is not None for unit in units) <= 4

    def test_without_dates_the_results_are_counted(self):
        (look,) = outlooks(self.a_unit(np.arange(20.0), dated=False), {})
        assert not look.history.dated
        assert look.trend.slope == pytest.approx(1.0, rel=0.05)

    def test_numbers_that_were_held_or_are_few_are_not_followed(self):
        assert outlooks(self.a_unit(np.arange(4.0)), {}) == []
        assert outlooks(self.a_unit(np.arange(9.0), std=None), {}) == []

    @pytest.mark.slow
    @pytest.mark.parametrize("text", ["", "backlash.width: wide", "- 1"])
    def test_limits_that_are_none_are_refused(self, tmp_path, text):
        file = tmp_path / "limits.yaml"
        file.write_text(text)
        with pytest.raises(InputError, match=r"limits\.yaml"):
            read_limits(file)
>>>>>>> e1dd71ba6e4b2055c0cc3e639e1c09da5dbf2796

"""What a campaign judges: each recording of each unit once, as the command judges it."""

import errno
import importlib
import os
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest
import typer

from ema_bench_replay.bags.bag_writer import write_bag
from ema_bench_replay.bags.stream_writer import StreamWriter
from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording
from ema_twin_sim.campaign import engine, work
from ema_twin_sim.campaign.engine import Outcome
from ema_twin_sim.campaign.jobs import Grouping, Job, Task, find_jobs
from ema_twin_sim.campaign.results import DONE, FAILED, REFUSED, SCHEMA
from ema_twin_sim.campaign.store import Store
from ema_twin_sim.campaign.units import units_of
from ema_twin_sim.campaign.work import judged
from ema_twin_sim.commands import campaign as command
from ema_twin_sim.words.units import counts_words
from tests.command_line import done_here

COMPARE = Task("compare", "polito_bench")
TIMED = r"(?P<unit>EMA\d+)_(?P<time>[\d-]+)"


def put(folder, *names):
    """Recordings, as far as their names go."""
    for name in names:
        (folder / name).write_text("a\n")


def jobs_of(folder, pattern=None, together="recording", **more):
    return find_jobs(Grouping.of(folder, pattern, together), COMPARE, **more)


class TestJobs:
    def test_a_unit_is_a_folder(self, folder):
        jobs = jobs_of(folder)
        assert [(job.unit, Path(job.name).suffix) for job in jobs] == [("A", ".CSV")] * 2 + [("B", ".CSV")] * 2

    def test_links_to_the_folders_of_units_are_followed_but_not_in_circles(self, tmp_path):
        (tmp_path / "store" / "EMA7" / "day").mkdir(parents=True)
        put(tmp_path / "store" / "EMA7" / "day", "a.csv")
        (tmp_path / "store" / "EMA7" / "day" / "back").symlink_to(tmp_path / "store" / "EMA7")
        (tmp_path / "fleet").mkdir()
        (tmp_path / "fleet" / "EMA7").symlink_to(tmp_path / "store" / "EMA7")
        (job,) = jobs_of(tmp_path / "fleet")
        assert (job.unit, job.name) == ("EMA7", "EMA7/day/a.csv")

    def test_text_files_of_other_names_are_read_where_there_is_nothing_else(self, tmp_path):
        told = []
        put(tmp_path, "a.txt", "b.txt")
        assert [job.name for job in jobs_of(tmp_path, tell=told.append)] == ["a.txt", "b.txt"]
        put(tmp_path, "c.csv")
        assert [job.name for job in jobs_of(tmp_path, tell=told.append)] == ["c.csv"]
        assert told[0].endswith("holds no .csv or .mcap file; reading its 2 .txt files instead")
        assert "leaving out its 2 .txt files beside 1 recording in .csv or .mcap files; rename those" in told[1]
        put(tmp_path, "d.csv")
        jobs_of(tmp_path, tell=told.append)
        assert len(told) == 2  # a few notes beside the recordings are nothing to tell

    def test_a_pattern_tells_unit_and_time(self, tmp_path):
        put(tmp_path, "EMA7_2026-03-01.csv", "EMA8_2026-03-02.csv", "notes.csv")
        told = []
        jobs = jobs_of(tmp_path, TIMED, "unit", tell=told.append)
        assert [(job.unit, job.time.day) for job in jobs] == [("EMA7", 1), ("EMA8", 2)]
        assert "notes.csv" in told[0]

    def test_recordings_that_are_judged_together_have_the_time_of_the_last(self, tmp_path):
        put(tmp_path, "EMA7_2026-03-01.csv", "EMA7_2026-03-09.csv", "EMA7_2026-03-05.csv")
        (job,) = jobs_of(tmp_path, TIMED, "unit")
        assert job.time.day == 9

    def test_a_time_that_is_none_leaves_one_recording_out(self, tmp_path):
        put(tmp_path, "EMA7_2026-03-01.csv", "EMA7_2026-13-01.csv", "EMA8_2026-03-02.csv")
        told = []
        jobs = jobs_of(tmp_path, TIMED, tell=told.append)
        assert [job.name for job in jobs] == ["EMA7_2026-03-01.csv", "EMA8_2026-03-02.csv"]
        (one,) = told
        assert "EMA7_2026-13-01.csv: 2026-13-01 is not an ISO 8601 time" in one and one.endswith("left out")

    def test_a_pattern_that_finds_no_time_at_all_is_refused(self, tmp_path):
        put(tmp_path, "EMA7_2026-13-01.csv", "EMA8_2026-14-02.csv")
        told = []
        with pytest.raises(InputError, match="of all 2 recordings none has a time"):
            jobs_of(tmp_path, TIMED, tell=told.append)
        (one,) = told
        assert one.endswith("left out, as are 1 more")

    def test_a_pattern_that_matches_nothing_is_refused(self, tmp_path):
        put(tmp_path, "EMA7.csv", "EMA8.csv")
        with pytest.raises(InputError, match=r"none of 2 recordings .* matches --unit; the first is EMA7.csv"):
            jobs_of(tmp_path, r"(?P<unit>XYZ\d)")

    @pytest.mark.parametrize(
        ("pattern", "reason"),
        [("(", "no regular"), ("EMA", "its groups are wrong"), ("(?P<unit>.)(?P<day>.)", "its groups are wrong")],
    )
    def test_a_pattern_without_a_unit_is_refused(self, tmp_path, pattern, reason):
        with pytest.raises(InputError, match=reason):
            Grouping.of(tmp_path, pattern, "recording")

    def test_a_recording_that_changes_is_another_job(self, folder):
        before = {job.name: job.key for job in jobs_of(folder)}
        changed = folder / "B" / "torn.CSV"
        changed.write_text("time;current\n0;0\n")
        after = {job.name: job.key for job in jobs_of(folder)}
        assert {name for name in before if before[name] != after[name]} == {"B/torn.CSV"}
        fits = find_jobs(Grouping.of(folder, None, "recording"), Task("fit", "polito_bench"))
        assert not {*after.values()} & {job.key for job in fits}

    def test_a_recording_that_was_split_is_one(self, tmp_path):
        writer = StreamWriter(tmp_path / "A" / "run", max_size=1)
        writer.add_topic("/t", "std_msgs/msg/Empty", "")
        for moment in (1, 2):
            writer.write("/t", b"", moment, moment)
            writer.flush()
        writer.finish()
        (tmp_path / "A" / "run" / "metadata.yaml").unlink()  # as where it was killed
        (job,) = jobs_of(tmp_path)
        assert [Path(part).name for part in job.recordings[0]] == ["run.mcap", "run_1.mcap"]

    def test_results_beneath_the_folder_are_no_recordings(self, folder):
        (folder / "results").mkdir()
        (folder / "results" / "copy.csv").write_text("a\n")
        jobs = jobs_of(folder, together="folder", skipped=(folder / "results",))
        assert [job.unit for job in jobs] == ["A", "B"]


class TestWork:
    def test_a_recording_is_judged_as_the_command_judges_it(self, folder):
        from ema_bench_replay.load import load
        from ema_twin_sim.comparison.compare import compare
        from ema_twin_sim.model import load_model

        job = jobs_of(folder)[0]
        row = judged(job, COMPARE)[0]
        overall = compare([load(job.recordings[0][0])], load_model("polito_bench")).overall
        assert {e["signal"]: e["rmse"] for e in row["errors"]} == {
            name: error["rmse"] for name, error in overall.items() if not error["driven"]
        }
        assert (row["status"], row["unit"], row["motion"]) == (DONE, "A", "rotary")

    def test_what_cannot_be_judged_has_a_row(self, folder, monkeypatch):
        jobs = jobs_of(folder)
        torn = judged(jobs[-1], COMPARE)[0]
        assert torn["status"] == REFUSED
        assert "torn.CSV" in torn["message"]
        monkeypatch.setattr("ema_twin_sim.campaign.work._of_recordings", lambda recordings: 1 / 0)
        broken = judged(jobs[0], COMPARE)[0]
        assert (broken["status"], "ZeroDivisionError" in broken["message"]) == (FAILED, True)

    def test_a_unit_is_judged_by_those_of_its_recordings_that_can_be_read(self, folder):
        told = []
        jobs = jobs_of(folder, together="unit")
        (row,) = judged(jobs[-1], COMPARE, told.append)
        assert (row["unit"], row["status"], len(row["content"])) == ("B", DONE, 1)
        (left_out,) = [warning for warning in told if "torn.CSV" in warning]
        assert left_out.endswith("left out of its unit") and left_out in row["warnings"]
        (unit,) = units_of([{**dict.fromkeys(SCHEMA.names), **row}])
        assert (unit.refused, unit.left_out, unit.as_json()["left_out"]) == (0, 1, 1) and left_out in unit.remarks
        assert counts_words(unit) == "1 result, 0 refused, 0 failed, 1 recording left out."
        (folder / "B" / "torn.CSV").replace(folder / "B" / "kept.CSV")
        for file in folder.glob("B/Banco*"):
            file.unlink()
        (row,) = judged(jobs_of(folder, together="unit")[-1], COMPARE)
        assert row["status"] == REFUSED

    def test_a_unit_that_is_judged_as_a_whole_was_last_recorded_when_its_last_recording_was(self, tmp_path):
        for day in (1, 9):
            start = (1_770_000_000 + 86_400 * day) * 10**9
            of = Recording(f"{day}", np.arange(0, 10**9, 10**7), {"current": np.ones(100)}, start)
            write_bag(of, tmp_path / "A")
        (row,) = judged(jobs_of(tmp_path, together="unit")[0], COMPARE)
        assert row["time"].timestamp() == 1_770_000_000 + 86_400 * 9

    def test_a_recording_whose_end_is_cut_is_told_of_and_judged(self, folder):
        whole, torn = next((folder / "A").glob("*.CSV")), folder / "B" / "torn.CSV"
        torn.write_bytes(whole.read_bytes()[:100_000])
        jobs = jobs_of(folder)
        told = []
        row = judged(jobs[-1], COMPARE, told.append)[0]
        assert row["status"] == DONE and row["warnings"] == told
        (one,) = told
        assert one.startswith("torn.CSV: line ") and "the last row is cut" in one


@pytest.mark.parametrize(
    ("options", "named"),
    [
        (["--model", "polito_bench", "--wavelength", "0.005"], "--wavelength 0.005: discover needs none"),
        (["--do", "health", "--without", "backlash"], "--without backlash: health looks for no effects"),
        (["--model", "polito_bench", "--do", "compare", "--without", "backlash"], "compare looks for no effects"),
    ],
)
def test_an_option_that_a_verb_does_not_use_is_refused(folder, tmp_path, options, named):
    with pytest.raises(InputError, match=named) as told:
        done_here("campaign", folder, "-o", tmp_path / "r", *options)
    assert "leave it out" in str(told.value) and not (tmp_path / "r").exists()


def test_a_disk_that_fails_is_no_internal_error(folder, monkeypatch):
    def unreadable(parts, import_map):
        raise OSError(errno.EIO, os.strerror(errno.EIO), str(parts[0]))

    monkeypatch.setattr(work, "load_runs", unreadable)
    job = jobs_of(folder)[0]
    (row,) = judged(job, COMPARE)
    assert row["status"] == FAILED and row["message"].startswith(f"{folder}/{job.name}: Input/output error; run")


def test_a_campaign_of_which_everything_failed_did_not_do_what_was_asked(folder, tmp_path, monkeypatch):
    def all_failed(client, jobs, task, store):
        return (Outcome(job, FAILED, "internal error", 0.1, ()) for job in jobs)

    monkeypatch.setattr(importlib.import_module("ema_twin_sim.campaign.campaign"), "campaign", all_failed)
    monkeypatch.setattr(engine, "cluster", lambda scheduler, workers: nullcontext())
    with pytest.raises(typer.Exit) as ended:
        command.run(folder, tmp_path / "r", model="polito_bench", do="compare")
    assert ended.value.exit_code == 1


def test_of_many_damaged_recordings_a_few_are_named_and_the_others_counted(monkeypatch, tmp_path, capsys):
    jobs = [Job(f"key {k}", "A", f"{k}.csv", ()) for k in range(8)]
    outcomes = [Outcome(job, DONE, "", 0.1, (f"{job.name}: the last row is cut",)) for job in jobs]
    monkeypatch.setattr("ema_twin_sim.campaign.campaign.campaign", lambda *_: iter(outcomes))
    counts = command._judge(None, jobs, COMPARE, Store.made(tmp_path / "results"))
    told = [line for line in capsys.readouterr().err.splitlines() if line.startswith("warning: ")]
    assert counts == {DONE: 8}
    assert told[:5] == [f"warning: A: {k}.csv: the last row is cut" for k in range(5)]
    assert len(told) == 6 and "3 more recordings" in told[5]


def test_of_many_refused_recordings_a_few_are_named_and_the_others_counted(monkeypatch, tmp_path, capsys):
    outcomes = [Outcome(Job(f"key {k}", "A", f"{k}.csv", ()), REFUSED, "is empty", 0.1) for k in range(8)]
    monkeypatch.setattr("ema_twin_sim.campaign.campaign.campaign", lambda *_: iter(outcomes))
    command._judge(None, [one.job for one in outcomes], COMPARE, Store.made(tmp_path / "results"))
    told = [line for line in capsys.readouterr().err.splitlines() if line.startswith("warning: ")]
    assert len(told) == 6 and told[5].startswith("warning: 3 more have no result; ema-twin units ")

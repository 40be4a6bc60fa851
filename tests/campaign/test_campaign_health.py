"""Health within a campaign: many runs a file, what is kept of each, and units judged by their own healthy tests."""

import itertools
import json
from datetime import datetime, timezone

import numpy as np
import pytest

from ema_bench_replay.bags.bag_writer import write_bag
from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording
from ema_bench_replay.traces.import_map import load_map
from ema_bench_replay.traces.many_runs import read_runs
from ema_twin_sim.campaign.campaign import outcome
from ema_twin_sim.campaign.health_rows import health_row, run_of
from ema_twin_sim.campaign.healthy import Healthy
from ema_twin_sim.campaign.jobs import Grouping, Task, find_jobs
from ema_twin_sim.campaign.results import DONE, FAILED, REFUSED
from ema_twin_sim.campaign.store import Store
from ema_twin_sim.campaign.unit_health import unit_health
from ema_twin_sim.campaign.units import units_of
from ema_twin_sim.campaign.work import judged
from ema_twin_sim.health import MotionRecord, judge, judge_run, learn, learn_from, run_features
from tests.command_line import done_here
from tests.stored_rows import complete

LEAD = 0.005  # m
HEALTH = Task("health", "", "cranfield_ball_screw", wavelength=LEAD)
HEADER = "sequence,test,time [s],set_point [mm],position_error [mm],current [A]"


def a_file(path, rng, tests, friction=1.0, runs=4):
    """A CSV of a made-up axis: tests of a few runs each, whose friction differs from test to test."""
    time = np.arange(0.0, 9.0, 0.04)
    command = np.interp(time, [0.0, 3.0, 6.0, 9.0], [0.0, 100.0, 100.0, 0.0])  # mm
    direction = np.sign(np.gradient(command))
    lines = [HEADER]
    for test in range(1, tests + 1):
        level = friction * (1.0 + 0.02 * rng.normal())
        for run in range(runs):
            error = direction + 0.05 * rng.normal(size=len(time))
            current = np.abs(direction * level + 0.02 * rng.normal(size=len(time)))
            number = (test - 1) * runs + run + 1
            lines += [
                f"{number},{test},{t:.2f},{c:.3f},{e:.4f},{i:.5f}"
                for t, c, e, i in zip(time, command, error, current, strict=True)
            ]
    path.write_text("\n".join(lines) + "\n")


@pytest.fixture(scope="module")
def rig(tmp_path_factory):
    """The folder of a rig: twelve healthy tests, four with more friction, and a file that is none."""
    folder = tmp_path_factory.mktemp("runs") / "rig"
    folder.mkdir()
    rng = np.random.default_rng(1)
    a_file(folder / "well.csv", rng, 12)
    a_file(folder / "dry.csv", rng, 4, friction=1.5)
    (folder / "torn.csv").write_text(HEADER + "\n1,1\n")
    return folder


@pytest.fixture(scope="module")
def rows(rig):
    jobs = find_jobs(Grouping.of(rig, None, "recording"), HEALTH)
    return [row for job in jobs for row in judged(job, HEALTH)]


def test_every_run_of_a_file_has_a_result(rows):
    names = [row["name"] for row in rows if row["status"] == DONE]
    assert len(names) == 64 and names[0] == "dry.csv test 1 run 1" and names[-1] == "well.csv test 12 run 48"
    assert [row["name"] for row in rows if row["status"] == REFUSED] == ["torn.csv"]
    assert {row["health"]["test"] for row in rows if row["status"] == DONE} >= {"dry.csv test 1", "well.csv test 1"}


def test_runs_that_are_judged_together_have_one_result(rig):
    jobs = find_jobs(Grouping.of(rig, r"(?P<unit>well|dry)", "unit"), HEALTH)
    assert [len(judged(job, Task("compare", "emps", "cranfield_ball_screw"))) for job in jobs] == [1, 1]


def test_what_is_kept_of_a_run_judges_as_the_run_does(rig, rows, tmp_path):
    """Through the store's file and back, nothing of a judgement changes."""
    store = Store.made(tmp_path / "r")
    store.write(rows)
    kept = {row["name"]: run_of(row["name"], row["health"]) for row in store.rows() if row["status"] == DONE}
    import_map = load_map("cranfield_ball_screw")
    records = {
        f"{name}.csv test {one.metadata['test']} run {one.name.rpartition('_')[2]}": MotionRecord.from_recording(
            one, f"{name}.csv test {one.metadata['test']}"
        )
        for name in ("well", "dry")
        for one in read_runs(rig / f"{name}.csv", import_map)
    }
    assert kept.keys() == records.keys()
    from_records = learn([r for name, r in records.items() if name.startswith("well")], wavelength=LEAD)
    from_kept = learn_from([kept[name] for name in records if name.startswith("well")])
    for name in records:
        one, other = judge(records[name], from_records), judge_run(kept[name], from_kept)
        assert (one.detected, one.family, one.words) == (other.detected, other.family, other.words)
        assert one.distance == pytest.approx(other.distance, rel=1e-6)


def test_a_unit_is_judged_by_its_healthy_tests(rows):
    (unit,) = units_of(complete(rows))
    health = unit_health(unit, Healthy.of(r"well\.csv test ([1-8]) ", 4))
    of = {test.name: test for test in health.tests}
    assert health.baselines[0].tests == 8 and health.baselines[0].runs == 32
    assert all(of[f"dry.csv test {k}"].detected == 4 for k in range(1, 5))
    assert {of[f"dry.csv test {k}"].named.family.value for k in range(1, 5)} <= {"friction up", "preload up"}
    assert sum(of[f"well.csv test {k}"].detected for k in range(9, 13)) == 0
    assert [*of][:2] == ["dry.csv test 1", "dry.csv test 2"] and [*of][-1] == "well.csv test 12"  # as numbers
    assert any("is unsigned (a magnitude)" in remark for remark in health.remarks)


def test_a_unit_without_enough_healthy_tests_is_not_judged(rows):
    (unit,) = units_of(complete(rows))
    few = unit_health(unit, Healthy.of("well.csv test [12] ", 4))
    assert not few.tests and any(
        "of 2 tests are too few to estimate how tests differ" in remark for remark in few.remarks
    )
    none = unit_health(unit, Healthy.of("nothing is called so", 4))
    assert not none.tests and any("no healthy recording is selected" in remark for remark in none.remarks)
    assert unit_health(units_of(complete([{**rows[0], "health": None}]))[0], Healthy()) is None


def test_motions_are_told_apart(rows):
    """A recording of another motion neither spoils the baseline nor is judged by it."""
    (unit,) = units_of(complete(rows))
    runs = [run_of(row["name"], row["health"]) for row in unit.rows if row["status"] == DONE]
    slow = [
        {
            **row,
            "name": f"slow {row['name']}",
            "health": {**row["health"], "top_speed": 0.3 * row["health"]["top_speed"]},
        }
        for row in unit.rows
        if row["status"] == DONE and row["name"].startswith("well.csv")
    ]
    (both,) = units_of(complete([*unit.rows, *slow[:40], {**slow[-1], "name": "other", "health": {
        **slow[-1]["health"], "travel": 9.0 * runs[0].motion[1]}}]))  # fmt: skip
    health = unit_health(both, Healthy.of(r"well\.csv test ([1-8]) ", 4))
    assert len(health.baselines) == 2 and [b.tests for b in health.baselines] == [8, 8]
    other = next(run for test in health.tests for run in test.runs if run.name == "other")
    assert other.detected is None and "travel" in " ".join(other.words)


@pytest.mark.parametrize("text", ["2", "(", ""])
def test_healthy_ones_that_are_none_are_refused(text, rows):
    if text:
        with pytest.raises(InputError, match=r"--healthy"):
            Healthy.of(text, 4)
    else:
        assert Healthy.of(None, 4) == Healthy()


def test_a_job_that_failed_in_part_is_done_again(tmp_path):
    """Rows of one try share the moment; an earlier one that failed leaves nothing behind."""
    store = Store.made(tmp_path / "r")

    def a_try(at, *statuses):
        job = {"key": "1", "unit": "A", "task": "health", "model": ""}
        done_at = datetime.fromtimestamp(at, timezone.utc)
        store.write(complete({**job, "name": n, "status": status, "done_at": done_at} for n, status in statuses))

    a_try(1, ("f.csv", FAILED))
    assert store.settled() == set()
    a_try(2, ("f.csv run 1", DONE), ("f.csv run 2", FAILED))
    assert store.settled() == set()
    a_try(3, ("f.csv run 1", DONE), ("f.csv run 2", DONE))
    assert store.settled() == {"1"}
    assert [(row["name"], row["status"]) for row in store.rows()] == [("f.csv run 1", DONE), ("f.csv run 2", DONE)]
    for k in range(9):
        other = {"key": f"other {k}", "unit": "A", "name": f"{k}", "status": DONE}
        store.write(complete([{**other, "done_at": datetime.fromtimestamp(k, timezone.utc)}]))
    store.merge_files()
    assert [row["name"] for row in store.rows() if row["key"] == "1"] == ["f.csv run 1", "f.csv run 2"]


def test_how_a_job_went_is_how_its_worst_run_went():
    def a_row(status):
        return {"status": status, "message": status, "seconds": 1.0}

    assert outcome(None, [a_row(DONE), a_row(REFUSED)]).status == DONE
    assert outcome(None, [a_row(DONE), a_row(FAILED)]).status == FAILED
    assert outcome(None, [a_row(REFUSED)] * 2).seconds == 2.0


def test_tests_are_told_by_paths_and_days(tmp_path):
    for place in ("U1/monday/a.csv", "U1/b.csv", "c.csv"):
        (tmp_path / place).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / place).write_text("x\n")
    jobs = find_jobs(Grouping.of(tmp_path, None, "recording"), HEALTH)
    assert {job.name: job.test for job in jobs} == {"U1/monday/a.csv": "monday", "U1/b.csv": None, "c.csv": None}
    pattern = r"(?P<unit>U1)/(?P<test>\w+)?"
    named = find_jobs(Grouping.of(tmp_path, pattern, "recording"), HEALTH)
    assert {job.name: job.test for job in named} == {"U1/monday/a.csv": "monday", "U1/b.csv": "b"}


def test_without_a_position_the_speed_is_integrated(tmp_path):
    """A stroke of 3 rad there and back at 1 rad/s; of its speed alone the same friction is found, and no wave."""
    time = np.arange(0.0, 8.0, 0.01)
    speed = np.select([time < 3.0, (time > 4.0) & (time < 7.0)], [1.0, -1.0])
    current = np.sign(speed) + 0.02 * np.random.default_rng(4).normal(size=len(time))
    position = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * 0.01)])
    stamps = (1e9 * time).round().astype(np.int64)
    for name, motion in (("speed", {"speed": speed}), ("position", {"motor_position": position})):
        write_bag(Recording(name, stamps, {"current": current, **motion}), tmp_path)
    jobs = find_jobs(Grouping.of(tmp_path, r"(?P<unit>speed|position)", "recording"), Task("health", ""))
    held = {job.unit: judged(job, Task("health", ""))[0] for job in jobs}
    of = {unit: run_of(unit, row["health"]) for unit, row in held.items()}
    levels = [of[unit].features.values["friction"].value for unit in ("speed", "position")]
    assert levels == pytest.approx([1.0, 1.0], abs=0.02)
    assert of["speed"].position_unit == "rad" and np.isnan(of["speed"].wavelength)
    assert "its speed is integrated instead" in held["speed"]["warnings"][0]


def test_what_has_neither_position_nor_speed_is_refused(tmp_path):
    write_bag(Recording("A", np.arange(100) * 10_000_000, {"current": np.ones(100)}), tmp_path)
    (job,) = find_jobs(Grouping.of(tmp_path, None, "recording"), Task("health", ""))
    assert "holds no position and no speed, by which health is judged" in judged(job, Task("health", ""))[0]["message"]


def test_a_run_without_motion_keeps_why():
    time = np.arange(0.0, 1.0, 0.01)
    still = run_features(MotionRecord("still", "1", time, np.zeros(100), np.ones(100)), LEAD)
    again = run_of("still", health_row(still))
    assert again.features is None and again.acquisition.findings == still.acquisition.findings
    assert "no stroke" in again.acquisition.findings[0]


@pytest.mark.slow
def test_a_real_ball_screw_is_judged_by_two_verbs(real, tmp_path):
    """Cranfield's rig: learnt from seven of its ten healthy tests, as the pattern says, and judged on all else."""
    folder, told = real / "cranfield_20kg", tmp_path / "units.json"
    done_here("campaign", folder, "--do", "health", "--map", "cranfield_ball_screw", "--wavelength", LEAD, "-o",
              tmp_path / "r")  # fmt: skip
    done_here("units", tmp_path / "r", "--healthy", r"^normal\.csv test [1-7] ", "--json", told)
    (unit,) = json.loads(told.read_text())
    assert unit["judged"] == 650 and unit["health"]["healthy"][0]["recordings"] == 35
    tests = unit["health"]["tests"]
    of = {
        condition: [*its]
        for condition, its in itertools.groupby(tests, key=lambda test: test["test"].partition(".csv")[0])
    }
    share = {c: sum(t["detected"] for t in its) / sum(t["judged"] for t in its) for c, its in of.items()}
    assert len(of) == 13 and sum(t["judged"] for t in of["normal"]) == 15
    assert share["normal"] <= 1 / 15
    assert min(share[c] for c in ("lack_of_lubrication_1", "lack_of_lubrication_2", "backlash_2", "spalling_7")) == 1.0
    assert share["backlash_1"] >= 0.9 and min(share["spalling_6"], share["spalling_8"]) >= 0.9
    named = {"lack_of_lubrication_1": "friction up", "lack_of_lubrication_2": "friction up", "backlash_1": "play"}
    named |= {f"spalling_{stage}": "local damage" for stage in range(2, 9)}
    for condition, family in named.items():
        assert np.mean([test["family"] == family for test in of[condition]]) >= 0.9
    assert any("is a copy of" in remark for remark in unit["remarks"])  # five runs stand twice in that data

"""An effort that is never negative is no magnitude if a load keeps it positive, as that of a hoist or an arm."""

from dataclasses import replace

import numpy as np
import pytest

from ema_bench_replay.load import load_runs
from ema_twin_sim.campaign.health_rows import health_row, run_of
from ema_twin_sim.campaign.unit_health import learnt_from
from ema_twin_sim.health import Family, MotionRecord, judge, judge_run, learn, run_features

TIME = np.arange(0.0, 12.0, 0.02)
SPEED = 0.1 * np.interp(TIME % 6.0, [0.0, 0.3, 2.7, 3.0, 3.3, 5.7, 6.0], [0.0, 1.0, 1.0, 0.0, -1.0, -1.0, 0.0])


def lift(rng, test, *, load=5.0, friction=1.0, magnitude=False, noise=0.02, unsigned=None):
    """Up and down at 0.1 m/s, against and with a load, with some inertia."""
    effort = (
        load + friction * np.tanh(SPEED / 1e-3) + 0.5 * np.gradient(SPEED, TIME) + noise * rng.normal(size=len(TIME))
    )
    effort = np.abs(effort) if magnitude else effort
    way = np.cumsum(SPEED) * 0.02 + 1e-6 * rng.normal(size=len(TIME))
    return MotionRecord(f"{test} {rng.integers(1 << 30)}", test, TIME, way, effort, unsigned=unsigned)


def lifts(rng, tests=8, repeats=3, **given):
    return [lift(rng, f"day {k}", friction=1.0 + 0.02 * off, **given)
            for k, off in enumerate(rng.normal(size=tests)) for _ in range(repeats)]  # fmt: skip


def seen(record, wavelength=np.nan):
    return run_features(record, wavelength)


@pytest.mark.parametrize(("load", "of_noise"), [(5.0, 0.02), (1.2, 0.02), (1.05, 0.1)])
def test_a_load_that_outweighs_friction_keeps_the_sign(load, of_noise):
    record = lift(np.random.default_rng(1), "a day", load=load, noise=of_noise)
    assert not seen(record).unsigned and not seen(record).acquisition.unsigned


@pytest.mark.parametrize("of_noise", [0.0, 0.02, 0.1])
def test_what_is_the_same_both_ways_and_zero_between_is_a_magnitude(of_noise):
    run = seen(lift(np.random.default_rng(1), "a day", load=0.0, noise=of_noise, magnitude=True))
    assert run.unsigned and "write `magnitude: false`" in run.acquisition.findings[0]


@pytest.mark.parametrize(
    ("change", "family"),
    [({"load": 6.5}, Family.LOAD), ({"friction": 1.3}, Family.FRICTION_UP)],
)
def test_a_lift_is_told_its_load_from_its_friction(change, family):
    rng = np.random.default_rng(2)
    learnt = learn(lifts(rng), wavelength=np.nan)
    told = judge(lift(rng, "another", **change), learnt)
    assert told.detected and told.ranked[0].family is family
    assert "Record a signed current" not in " ".join(told.words)


@pytest.mark.parametrize(("word", "unsigned"), [("", None), (", magnitude: true", True), (", magnitude: false", False)])
def test_the_word_of_the_map_decides(tmp_path, word, unsigned):
    record = lift(np.random.default_rng(3), "a day", load=0.0, magnitude=True)
    rows = zip(TIME, record.position, record.effort, strict=True)
    (tmp_path / "a.csv").write_text("t [s],x [m],i [A]\n" + "".join(f"{t:.2f},{x:.7f},{i:.4f}\n" for t, x, i in rows))
    (tmp_path / "map.yaml").write_text(
        "version: 1\ndescription: an axis\nmotion: linear\ntime: {column: 't \\[s\\]', unit: s}\nsignals:\n"
        "  output_position: {columns: ['x \\[m\\]'], unit: m}\n"
        f"  current: {{columns: ['i \\[A\\]'], unit: A{word}}}\n"
    )
    (recording,) = load_runs(tmp_path / "a.csv", import_map=str(tmp_path / "map.yaml"))
    read = MotionRecord.from_recording(recording, "a day")
    assert read.unsigned is unsigned
    run = seen(read)
    assert run.unsigned is (unsigned is not False)  # without a word its numbers decide
    assert bool(run.otherwise) is (unsigned is None)


def test_the_healthy_recordings_of_a_motion_decide_for_all_of_it():
    """Where a load hardly outweighs the friction, noise makes some efforts negative, which tell how to read all."""
    rng = np.random.default_rng(4)
    negative = [seen(lift(rng, f"day {k}", load=1.0, noise=0.05)) for k in range(6)]
    assert all(run.otherwise is None for run in negative)
    doubted = seen(lift(rng, "another", load=1.3, noise=0.05)).read_as(unsigned=True)
    assert doubted.unsigned and "so it is treated as unsigned" in doubted.acquisition.findings[0]
    learnt = learnt_from([*negative, replace(doubted, test="day 6")])
    (baseline,) = learnt.kinds
    assert not baseline.unsigned and baseline.runs == 7
    told = learnt.judge(doubted)
    assert told.detected is not None and not told.acquisition.unsigned
    assert not any("unsigned" in words for words in told.words)


def test_a_declared_magnitude_is_not_judged_by_signed_recordings():
    rng = np.random.default_rng(5)
    learnt = learnt_from([seen(one) for one in lifts(rng)])
    told = learnt.judge(seen(lift(rng, "another", magnitude=True, unsigned=True)))
    assert told.detected is None and "is a magnitude and that of the healthy recordings has a sign" in told.words[-1]


def test_what_is_kept_of_a_doubt_reads_both_ways():
    run = seen(lift(np.random.default_rng(6), "a day"))
    again = run_of(run.name, health_row(run))
    assert again.features == run.features and again.otherwise == run.otherwise
    assert again.read_as(unsigned=True).features == run.otherwise
    learnt = learnt_from([seen(one) for one in lifts(np.random.default_rng(7))]).kinds[0]
    assert judge_run(again, learnt).words == judge_run(run, learnt).words

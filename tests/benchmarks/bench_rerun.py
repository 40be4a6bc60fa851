"""What rerun's views cost: half an hour at 500 Hz as a file, and a live run's share of a core."""

import multiprocessing
import resource
import sys
import time

import numpy as np
import pytest

from ema_bench_replay.recording import Recording
from ema_twin_sim import load_model
from ema_twin_sim.report.content import shown
from ema_twin_sim.simulation.compared_signals import noise_floors
from ema_twin_sim.views import rerun_view
from ema_twin_sim.views.recording_views import write_views

UNIT = 2**20 if sys.platform == "darwin" else 2**10  # of ru_maxrss to a MiB
RATE = 500  # Hz
LONG = 1800  # s
LIVE = 20  # s
BATCHES = 20  # a second, as the nodes hand them on


def half_an_hour():
    """Half an hour of a machine that swings, as a drive would have recorded it."""
    time_ = np.arange(LONG * RATE) / RATE
    noise = np.random.default_rng(0).normal(size=(3, len(time_)))
    way = 124.0 * 0.02 * np.sin(2.0 * np.pi * time_)
    speed = 124.0 * 0.02 * 2.0 * np.pi * np.cos(2.0 * np.pi * time_)
    signals = {
        "current": 0.25 * np.sign(speed) + 0.003 * noise[0],
        "speed": speed + 0.002 * noise[1],
        "speed_setpoint": speed,
        "motor_position": way,
        "output_position": way / 124.0 + 1e-6 * noise[2],
    }
    return Recording("half_an_hour", np.round(time_ * 1e9).astype(np.int64), signals)


def cost_of_a_file(path):
    """Seconds and megabytes of comparing, seconds of writing, and the peak of memory [MiB] after each."""
    model, run = load_model("polito_bench"), half_an_hour()
    begin = time.perf_counter()
    given = shown([run], [model])
    compared, before = time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / UNIT
    begin = time.perf_counter()
    write_views(path, given, [model], [model.name])
    written, after = time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / UNIT
    return compared, before, written, after


@pytest.mark.timeout(600)
def test_half_an_hour_as_a_file(tmp_path, say):
    path = tmp_path / "long.rrd"
    with multiprocessing.get_context("spawn").Pool(1) as fresh:
        compared, before, written, after = fresh.apply(cost_of_a_file, (path,))
    say(f"\n  {'half an hour at 500 Hz as rerun views':<46}{'s':>8}{'peak MiB':>10}{'file MB':>9}")
    say(f"  {'  both simulations and their comparison':<46}{compared:>8.1f}{before:>10.0f}")
    say(f"  {'  the views, all of them':<46}{written:>8.1f}{after:>10.0f}{path.stat().st_size / 1e6:>9.0f}")


def test_live_share_of_a_core(tmp_path, say, monkeypatch):
    model = load_model("polito_bench")
    now = [0.0]
    monkeypatch.setattr(rerun_view.clock, "monotonic", lambda: now[0])  # a run that is played as fast as it goes
    view = rerun_view.RerunView(tmp_path / "live.rrd", "live", noise_floors(model), model=model)
    samples, names = np.arange(LIVE * RATE), ("current", "speed", "motor_position", "output_position")
    signals = {name: np.sin(samples / 80.0) for name in names}
    left = dict.fromkeys((*names, "unexplained_torque"), 0.01 * signals["speed"])
    begin = time.process_time()
    for rows in np.array_split(samples, LIVE * BATCHES):
        now[0] = rows[0] / RATE
        batch, rest = ({name: values[rows] for name, values in each.items()} for each in (signals, left))
        view.add(rows / RATE, batch, batch, rest)
    view.close()
    share = (time.process_time() - begin) / LIVE
    say(f"\n  live views at 500 Hz, share of a core: {100.0 * share:.1f} %")

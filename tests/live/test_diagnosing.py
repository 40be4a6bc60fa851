"""What the monitor's services are made of: history, jobs and answers, what is missing still, what to set."""

import io
import subprocess
import sys
import threading
import time

import numpy as np
import psutil
import pytest

from ema_bench_replay.errors import InputError
from ema_bench_replay.nodes.sample_codec import FIELDS
from ema_bench_replay.recording import Recording
from ema_bench_replay.sample import State
from ema_twin_sim.live.diagnosing.apply import settings_for
from ema_twin_sim.live.diagnosing.frames import Answer, Job, receive_answer, receive_job, send
from ema_twin_sim.live.diagnosing.judge import settings_between, still_missing
from ema_twin_sim.live.diagnosing.worker_process import WorkerProcess
from ema_twin_sim.live.trend import Trend
from ema_twin_sim.nodes.diagnosing.answer import diagnosis_message
from ema_twin_sim.nodes.diagnosing.history import ENOUGH, History
from tests.judged_effects import BOTH, OF_BOTH, entry, judged

PERIOD = 2_000_000


def state(run, k):
    signals = dict.fromkeys(FIELDS, np.nan)
    signals |= {"current": 0.1 * k, "output_position": 1.0 + k, "output_command": 2.0 + k, "output_angle_origin": 0.5}
    return State(run, k, 5_000_000_000 + k * PERIOD, signals)


def held(capacity, *lengths):
    """A history of runs of these lengths."""
    history = History(capacity)
    for number, length in enumerate(lengths, start=1):
        for k in range(length):
            history.add(number, state(number, k))
    return history


class TestHistory:
    def test_a_window_is_the_last_seconds_with_positions_from_zero(self):
        (recording,) = held(100_000, 10_000).recordings(4.0, "bench")
        assert recording.duration == pytest.approx(4.0, abs=0.0)
        assert set(recording.signals) == {"current", "output_position", "output_command"}
        assert recording.signals["current"][-1] == pytest.approx(999.9)
        first = 10_000 - len(recording)
        assert recording.signals["output_position"][0] == 0.0
        assert recording.output_angle_origin == 0.5 + 1.0 + first
        assert recording.signals["output_command"][0] == 1.0  # measured from the same zero
        assert recording.start == 5_000_000_000 + first * PERIOD

    def test_memory_is_bounded_and_holds_the_newest(self):
        (recording,) = held(5000, 12_345).recordings(0.0, "bench")
        assert len(recording) == 5000
        assert recording.signals["current"] == pytest.approx(0.1 * np.arange(7345, 12_345))

    def test_a_window_reaches_into_earlier_runs(self):
        recordings = held(100_000, 2001, 2001, 2001).recordings(6.0, "bench")
        assert [recording.duration for recording in recordings] == pytest.approx([2.0, 4.0])
        assert [recording.name for recording in recordings] == ["bench, run 2", "bench, run 3"]

    def test_without_a_window_it_is_the_run_and_enough_before_it(self):
        recordings = held(100_000, 6001, 6001, 1001).recordings(0.0, "b")
        assert [recording.duration for recording in recordings] == pytest.approx([12.0, 12.0, 2.0])
        assert len(held(100_000, 6001, round(ENOUGH / 2e-3) + 10).recordings(0.0, "b")) == 1

    def test_nothing_compared_is_refused(self):
        with pytest.raises(InputError, match="no sample was compared yet"):
            History(1000).recordings(0.0, "bench")


def test_jobs_and_answers_come_back_as_they_were_sent():
    signals = {"current": np.array([0.0, np.nan, 1.0, 2.0, 3.0])}
    recording = Recording("a run", np.arange(5) * PERIOD, signals, 7, 0.25, np.nan, {"map": "x"})
    sent = Answer({"verdict": "none", "none": 1.0}, [{"effect": "backlash"}], {"effects.backlash.enabled": True})
    stream = io.BytesIO()
    send(stream, Job("m.yaml", "b.yaml", ("own.py",), (recording, recording)))
    send(stream, sent)
    stream.seek(0)
    job = receive_job(stream)
    assert (job.model, job.base, job.effect_files) == ("m.yaml", "b.yaml", ("own.py",))
    for read in job.recordings:
        assert (read.name, read.start, read.motor_angle_origin, dict(read.metadata)) == ("a run", 7, 0.25, {"map": "x"})
        assert np.isnan(read.output_angle_origin)
        np.testing.assert_array_equal(read.stamps, recording.stamps)
        np.testing.assert_array_equal(read.signals["current"], recording.signals["current"])
    assert receive_answer(stream) == sent
    assert receive_job(stream) is None
    torn = io.BytesIO(stream.getvalue()[:300])
    assert receive_job(torn) is None


class TestWhatIsMissingStill:
    def test_nothing_was_applied(self):
        assert still_missing(BOTH, []) == BOTH

    def test_one_of_two_is_there(self):
        left = still_missing(BOTH, [("backlash", ())])
        assert left["verdict"] == "stribeck_friction"
        assert [e["effect"] for e in left["ranking"]] == ["stribeck_friction", "cogging"]

    def test_all_are_there(self):
        left = still_missing(BOTH, [("backlash", ()), ("stribeck_friction", ())])
        assert left["verdict"] == "none"
        assert left["none"] == pytest.approx(1.0)

    def test_what_is_left_is_as_probable_as_it_was(self):
        """Effects are missing each by itself: that one is there now says nothing of the others."""
        left = still_missing(BOTH, [("backlash", ())])
        assert [e["probability"] for e in left["ranking"]] == [0.97, 0.1] and left["none"] == 0.0
        alone = judged(entry("backlash", 0.98, True), verdict="backlash", unknown=0.02)
        assert still_missing(alone, [("backlash", ())])["none"] == pytest.approx(0.98)
        beside = judged(entry("backlash", 0.98, True), verdict="unknown", unknown=0.98)
        left = still_missing(beside, [("backlash", ())])
        assert (left["verdict"], left["none"], left["unknown"]) == ("unknown", 0.0, 0.98)

    def test_what_was_applied_and_does_not_show_is_told(self):
        left = still_missing(BOTH, [("gravity_load", ())])
        assert any("gravity_load" in warning for warning in left["warnings"])
        assert left["verdict"] == "backlash"


class TestWhatToSet:
    ANSWER = Answer(
        BOTH,
        BOTH["ranking"][:2],
        {
            "effects.backlash.width": 0.004, "effects.backlash.enabled": True,
            "effects.stribeck_friction.torque": 0.08, "effects.stribeck_friction.enabled": True,
            "machine.motor_inertia": 1e-3,
        },
    )  # fmt: skip

    def test_all_of_it(self):
        settings, words = settings_for(self.ANSWER, [])
        assert settings == self.ANSWER.settings
        assert "backlash width 4.0 ± 0.4 mrad" in words and "stribeck_friction" in words
        assert words.endswith("; and 1 constant refitted")

    def test_one_of_them(self):
        settings, _ = settings_for(self.ANSWER, ["backlash"])
        assert settings == {"effects.backlash.width": 0.004, "effects.backlash.enabled": True}

    def test_one_that_was_only_a_candidate(self):
        settings, words = settings_for(self.ANSWER, ["cogging"])
        assert settings == {"effects.cogging.enabled": True} and words == "cogging"

    @pytest.mark.parametrize(
        ("effects", "words"), [(["backlsh"], "did you mean 'backlash'"), (["nothing"], "known are")]
    )
    def test_what_it_does_not_hold(self, effects, words):
        with pytest.raises(InputError, match=words):
            settings_for(self.ANSWER, effects)

    def test_nothing_found(self):
        with pytest.raises(InputError, match=r"found nothing to add .*none"):
            settings_for(Answer(judged(verdict="none", none=1.0)), [])

    def test_settings_make_of_one_model_the_other(self, stock):
        before = stock
        after = before.with_effect("backlash", {"width": 0.003}).with_effect("cogging", options={"order": "12"})
        after = after.with_value("machine.motor_inertia", 8e-4)
        running = before.with_effect("backlash", enabled=False).with_effect("cogging", enabled=False)
        for path, value in settings_between(before, after).items():
            running = running.with_setting(path, value)
        assert dict(running.active) == dict(after.active)
        assert running.value("machine.motor_inertia") == 8e-4
        assert settings_between(after, after) == {}


@pytest.mark.parametrize(("removed", "share"), [(1.226, 1.0), (-3.0, 0.0), (0.5, 0.5), (None, np.nan)])
def test_a_share_of_the_error_is_from_none_to_all(removed, share):
    content = {**OF_BOTH, "ranking": [{**entry("backlash", 1.0, True), "error_removed": removed}]}
    assert diagnosis_message(content, 0, 1, 12.0).ranking[0].error_removed == pytest.approx(share, nan_ok=True)


class TestTrend:
    def test_a_steady_error_has_none(self):
        trend = Trend(5.0)
        noise = np.random.default_rng(1).normal(1.0, 0.05, 400)
        for k, value in enumerate(noise):
            trend.add(5.0 * k, {"current": value, "speed": np.nan})
        assert trend.growing() is None
        assert abs(trend.slopes()["current"]) < 1e-4 and "speed" not in trend.slopes()

    def test_a_growing_one_is_named_across_runs(self):
        trend = Trend(5.0)
        noise = np.random.default_rng(2).normal(1.0, 0.02, 3000)
        for run in range(3):
            for k in range(1000):
                elapsed = 0.1 * k
                error = 2.0 * noise[k] * (1.0 + (100.0 * run + elapsed) / 1800.0)
                trend.add(elapsed, {"current": 0.01, "speed": error})
        name, share = trend.growing()
        assert name == "speed"
        assert share == pytest.approx(2.0 / 1.08, rel=0.1)  # of its mean in an hour
        trend.clear()
        assert trend.growing() is None and trend.slopes() == {}

    def test_only_the_last_hour_counts_and_takes_no_more_room_as_it_comes(self):
        """The slope is that of the last 720 windows alone: before them the error fell."""
        trend = Trend(5.0)
        for k in range(1500):
            trend.add(5.0 * k, {"current": 9.0 - 0.01 * k if k < 780 else 0.002 * k})
        assert trend.slopes()["current"] == pytest.approx(0.002 / 5.0)
        times, errors = trend._errors["current"].held
        assert times.tolist() == [5.0 * k for k in range(780, 1500)]
        assert errors[-1] == pytest.approx(0.002 * 1499)
        room = trend._errors["current"]._rows
        trend.add(7500.0, {"current": 1.0})
        assert trend._errors["current"]._rows is room


@pytest.mark.slow
def test_the_process_judges_and_is_asked_again(recording, stock):
    worker = WorkerProcess()
    try:
        answer = worker.ask([recording.between(0.0, 0.5)], stock, stock)
        assert answer.diagnosis is None and "of motion faster than" in answer.refusal  # too short: refused, not failed
        process = worker.start()
        process.kill()
        process.wait()
        assert worker.ask([recording.between(0.0, 0.5)], stock, stock).refusal == answer.refusal
        assert worker.start() is not process
    finally:
        worker.close()
    with pytest.raises(InputError, match="monitor is shutting down"):
        worker.start()


def test_closing_ends_a_diagnosis_that_is_being_made(recording, stock):
    worker, refused = WorkerProcess(), []

    def ask():
        try:
            worker.ask([recording] * 8, stock, stock)
        except InputError as error:
            refused.append(str(error))

    asking = threading.Thread(target=ask)
    process = worker.start()
    asking.start()
    _until(lambda: _computes(process.pid))
    worker.close()
    asking.join(20.0)
    assert process.poll() is not None and "monitor is shutting down" in refused[0]


@pytest.mark.slow
def test_a_killed_node_leaves_no_diagnosis_behind(ramp):
    program = f"""
import threading, time
from ema_bench_replay.load import load
from ema_twin_sim.model import load_model
from ema_twin_sim.live.diagnosing.worker_process import WorkerProcess
worker, model, recording = WorkerProcess(), load_model("polito_bench"), load({str(ramp)!r})
print(worker.start().pid, flush=True)
worker.ask([recording] * 8, model, model)
"""
    node = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    worker = int(node.stdout.readline())
    _until(lambda: _computes(worker))
    node.kill()
    node.communicate()
    _until(lambda: not _runs(worker))


def _until(condition):
    end = time.monotonic() + 60.0
    while not condition():
        assert time.monotonic() < end, "nothing came of it in time"
        time.sleep(0.05)


def _computes(pid):
    """Whether a process is at work: with more threads than the one that reads and the one that watches."""
    return psutil.Process(pid).num_threads() > 2


def _runs(pid):
    try:
        return psutil.Process(pid).status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False


@pytest.fixture(scope="module")
def recording(ramp):
    from ema_bench_replay.load import load

    return load(ramp)

"""Counters: wraps and jumps put right, and nothing else touched."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ema_bench_replay.traces.counters import unwrap_counts
from ema_bench_replay.traces.import_map import load_map
from ema_bench_replay.traces.trace_csv import read_trace
from ema_bench_replay.traces.trace_table import read_table

PER_REVOLUTION = 40960
LIMITS = {"maximum_speed": 942.5, "maximum_acceleration": 30000.0}
PERIOD = 2e-3


def motion(kind: str, samples: int = 400) -> tuple[np.ndarray, np.ndarray]:
    """Time and counts of a shaft that moves as a bench's may."""
    time = np.arange(samples) * PERIOD
    angle = {
        "rest": 0 * time,
        "ramp": 12.4 * time,
        "fast": -800.0 * time,
        "sine": 2.5 * np.sin(2 * math.pi * time),
        # From rest to 20 rad/s with the full torque on the bare motor, and back.
        "step": np.where(time < 0.3, 0.0, np.where(time < 0.302, 5000.0 * (time - 0.3) ** 2, 20.0 * (time - 0.301))),
    }[kind]
    noise = np.random.default_rng(3).normal(0, 0.5, samples)
    return time, np.rint(angle * PER_REVOLUTION / (2 * math.pi) + noise).astype(np.int64) - 20480


@pytest.mark.parametrize("kind", ["rest", "ramp", "fast", "sine", "step"])
def test_a_good_counter_is_left_alone(kind):
    time, counts = motion(kind)
    repaired, findings = unwrap_counts(counts, time, PER_REVOLUTION, **LIMITS)
    assert findings == [] and np.array_equal(repaired, counts)


@given(
    start=st.integers(0, 2**32 - 1),
    speed=st.integers(-10_000, 10_000),
    signed=st.booleans(),
    bits=st.sampled_from([16, 24, 32]),
)
@settings(deadline=None)
def test_wraps_are_undone_exactly(start, speed, signed, bits):
    true = start % 2**bits + speed * np.arange(50, dtype=np.int64)
    shown = (true + (2 ** (bits - 1) if signed else 0)) % 2**bits - (2 ** (bits - 1) if signed else 0)
    repaired, findings = unwrap_counts(shown, np.arange(50) * PERIOD, PER_REVOLUTION, bits=bits, **LIMITS)
    assert np.array_equal(repaired - repaired[0], true - true[0]) and repaired[0] == shown[0]
    assert all(finding.kind == "wrap" and abs(finding.counts) == 2**bits for finding in findings)


@pytest.mark.parametrize("kind", ["rest", "ramp", "fast", "sine", "step"])
@pytest.mark.parametrize("place", [1, 2, 57, 200, 397, 399])
@pytest.mark.parametrize("revolutions", [1, -3, 1000])
def test_jumps_of_whole_revolutions_are_undone_exactly(kind, place, revolutions):
    time, counts = motion(kind)
    shown = counts.copy()
    shown[place:] += revolutions * PER_REVOLUTION
    repaired, [finding] = unwrap_counts(shown, time, PER_REVOLUTION, **LIMITS)
    assert np.array_equal(repaired, counts)
    assert (finding.kind, finding.sample, finding.revolutions, finding.whole) == ("jump", place, revolutions, True)
    assert "whole revolutions" in finding.describe(time[place])


@pytest.mark.parametrize("kind", ["rest", "ramp", "fast", "sine", "step"])
@given(place=st.integers(1, 399), size=st.integers(2500, 10**7), sign=st.sampled_from([-1, 1]))
@settings(deadline=None)
def test_other_jumps_are_taken_out_to_what_the_neighbours_say(kind, place, size, sign):
    time, counts = motion(kind)
    shown = counts.copy()
    shown[place:] += sign * size
    repaired, [finding] = unwrap_counts(shown, time, PER_REVOLUTION, **LIMITS)
    assert finding.sample == place
    # What is near to whole revolutions is taken for them; else the neighbours' speed is good to a few counts.
    assert np.abs(repaired - counts).max() <= 0.005 * PER_REVOLUTION + 20
    assert np.array_equal(repaired[:place], counts[:place])


def test_a_jump_by_a_power_of_two_is_undone_exactly():
    time, counts = motion("ramp")
    shown = counts.copy()
    shown[100:] -= 2**20
    repaired, [finding] = unwrap_counts(shown, time, PER_REVOLUTION, **LIMITS)
    assert np.array_equal(repaired, counts) and not finding.whole
    jump = "-1048576 counts (-25.6 revolutions, not whole)"
    assert finding.describe(0.2) == f"counter jumped by {jump} at 0.200 s; repaired"


def test_a_spike_and_several_jumps():
    time, counts = motion("ramp")
    shown = counts.copy()
    shown[50] += 2 * PER_REVOLUTION
    shown[120:] += PER_REVOLUTION
    shown[122:] -= 5 * PER_REVOLUTION
    repaired, findings = unwrap_counts(shown, time, PER_REVOLUTION, **LIMITS)
    assert np.array_equal(repaired, counts)
    assert [(finding.sample, finding.revolutions) for finding in findings] == [(50, 2), (51, -2), (120, 1), (122, -5)]


@pytest.mark.parametrize("kind", ["rest", "ramp", "sine"])
@pytest.mark.parametrize("place", [50, 200, 397])
@pytest.mark.parametrize("size", [-2500, 900, 40000])
def test_one_wrong_reading_leaves_no_offset(kind, place, size):
    """Stamps are unequal, so that the way there may be possible and the way back not, or the other way round."""
    time, counts = motion(kind)
    time = time + 4e-4 * np.sin(np.arange(len(time)) ** 2)
    shown = counts.copy()
    shown[place] += size
    repaired, findings = unwrap_counts(shown, time, PER_REVOLUTION, **LIMITS)
    others = np.arange(len(counts)) != place
    assert np.array_equal(repaired[others], counts[others])
    assert [finding.sample for finding in findings] in ([], [place, place + 1])


def test_motion_across_a_gap_is_no_jump():
    time, counts = motion("ramp")
    kept = np.r_[0:100, 250:400]
    repaired, findings = unwrap_counts(counts[kept], time[kept], PER_REVOLUTION, **LIMITS)
    assert findings == [] and np.array_equal(repaired, counts[kept])


def test_few_samples():
    for count in range(1, 8):
        time, counts = motion("ramp", count)
        assert np.array_equal(unwrap_counts(counts, time, PER_REVOLUTION, **LIMITS)[0], counts)


def test_recorded_jump_of_the_bench(bench_cases):
    """The bench's motor counter lost 2^20 counts in one of its traces; its other traces are whole."""
    siemens = load_map("siemens")
    jumped = read_trace(bench_cases / "dev10" / "train" / "BancoEMA_ramp_0.1.CSV", siemens)
    [warning] = jumped.warnings
    assert "r4820: counter jumped by -1048576 counts (-25.6 revolutions, not whole) at 6.786 s" in warning
    motor, output = (jumped.signals[name] for name in ("motor_position", "output_position"))
    assert np.abs(motor - 124 * output).max() < 0.6  # 124 · 0.004 rad of hidden backlash


def test_no_finding_in_good_recordings(traces):
    siemens = load_map("siemens")
    for path in traces:
        recording = read_trace(path, siemens)
        assert recording.warnings == ()
        [raw] = [column for name, column in read_table(path).numbers.items() if name.endswith("r4820")]
        counts = np.rint(recording.signals["motor_position"] * PER_REVOLUTION / (2 * math.pi))
        assert np.array_equal(counts, raw - raw[0])

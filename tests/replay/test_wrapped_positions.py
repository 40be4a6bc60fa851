"""Positions that start again after a period that the import map names."""

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_bench_replay.load import load
from ema_bench_replay.traces.wrapped_angle import unwrapped
from tests.trace_text import write_columns, write_map

TIME = np.arange(1500) * 2e-3
WAY = 40.0 * np.sin(1.5 * TIME)  # rad, farther than 25


def wrapped(way, period):
    return np.mod(way + 0.5 * period, period) - 0.5 * period


def read(tmp_path, values, keys, motion="rotary"):
    write_columns(tmp_path / "run.csv", {"time": TIME, "angle": values})
    signals = {"motor_position": f"{{columns: [angle], {keys}}}"}
    own = write_map(tmp_path, signals, f"motion: {motion}\ntime: {{column: time, unit: s}}")
    return load(tmp_path / "run.csv", import_map=own)


@pytest.mark.parametrize(
    ("unit", "size", "factor"),
    [("rad", 1.0, ""), ("deg", np.pi / 180.0, ""), ("rev", 2.0 * np.pi, ""), ("rad", 1.0, ", factor: -1")],
)
def test_a_position_is_counted_on_after_the_period_of_the_map(tmp_path, unit, size, factor):
    values = wrapped(WAY / size, 25.0 / size)
    period = f"wraps_after: {{value: {25.0 / size:.12g}, unit: {unit}}}"
    recording = read(tmp_path, values, f"unit: {unit}, {period}{factor}")
    sign = -1.0 if factor else 1.0
    assert recording.signals["motor_position"] == pytest.approx(sign * (WAY - WAY[0]), abs=1e-6)
    assert any("(`wraps_after` of the map)" in warning for warning in recording.warnings)


def test_the_period_may_be_in_another_unit_than_the_column(tmp_path):
    recording = read(tmp_path, wrapped(np.rad2deg(WAY), 1440.0), "unit: deg, wraps_after: {value: 4, unit: rev}")
    assert recording.signals["motor_position"] == pytest.approx(WAY - WAY[0], abs=1e-6)


def test_a_counter_starts_again_after_whole_counts(tmp_path):
    counts = np.rint(WAY * 1000.0 / (2.0 * np.pi))
    shown = np.mod(counts, 4096)
    keys = "counts_per_revolution: 1000, wraps_after: {value: 4.096, unit: rev}"
    recording = read(tmp_path, shown, keys)
    assert recording.signals["motor_position"] == pytest.approx((counts - counts[0]) * 2e-3 * np.pi, abs=1e-9)
    assert not any("fractions" in warning for warning in recording.warnings)


def test_a_linear_position_may_start_again_too(tmp_path):
    recording = read(tmp_path, wrapped(WAY, 25.0), "unit: mm, wraps_after: {value: 25, unit: mm}", "linear")
    assert recording.signals["motor_position"] == pytest.approx(1e-3 * (WAY - WAY[0]), abs=1e-9)


def test_one_new_start_is_enough_and_none_says_nothing(tmp_path):
    """A map holds for all recordings of a machine, however often their position starts again."""
    values = wrapped(14.0 * np.sin(0.5 * TIME), 25.0)
    recording = read(tmp_path, values, "unit: rad, wraps_after: {value: 25, unit: rad}")
    assert np.abs(np.diff(recording.signals["motor_position"])).max() < 1.0
    assert any("1 times" in warning for warning in recording.warnings)
    recording = read(tmp_path, 10.0 * np.sin(TIME), "unit: rad, wraps_after: {value: 25, unit: rad}")
    assert not any("wraps_after" in warning for warning in recording.warnings)


def test_missing_values_stay_missing():
    shown = wrapped(WAY, 25.0)
    shown[[5, 700]] = np.nan
    on, times = unwrapped(shown, 25.0)
    assert times == np.count_nonzero(np.abs(np.diff(shown[np.isfinite(shown)])) > 12.5)
    assert np.isnan(on[[5, 700]]).all() and np.nanmax(np.abs(on - on[0] - WAY + WAY[0])) < 1e-9
    assert unwrapped(np.full(3, np.nan), 25.0)[1] == 0


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ("unit: rad, wraps_after: 25", "signals.motor_position.wraps_after: is no mapping"),
        ("unit: rad, wraps_after: {value: 25}", "the key 'unit' is missing"),
        ("unit: rad, wraps_after: {value: 25, unit: m}", "wraps_after.unit: 'm' is not possible"),
        ("unit: rad, wraps_after: {value: 0, unit: rad}", "wraps_after.value: 0 is out of range"),
    ],
)
def test_a_period_that_cannot_be_is_refused(tmp_path, keys, said):
    with pytest.raises(InputError, match=said):
        read(tmp_path, WAY, keys)

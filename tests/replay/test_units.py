"""Units: of signals, of import maps, of linear machines."""

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import SIGNALS
from ema_bench_replay.traces.import_map import load_map
from ema_bench_replay.traces.trace_csv import read_trace
from ema_bench_replay.units import ALL_UNITS, MOTIONS, signal_unit, unit_in, units_of, usual_spelling
from tests.one_line import refused_in_one_line
from tests.trace_text import write_map


def read(tmp_path, signals, header, rows, motion="rotary"):
    own = write_map(tmp_path, signals, f"motion: {motion}\ntime: {{column: t, unit: s}}")
    (tmp_path / "run.csv").write_text("\n".join([header, *rows]) + "\n")
    return read_trace(tmp_path / "run.csv", load_map(own))


@pytest.mark.parametrize("motion", MOTIONS)
def test_every_signal_has_a_unit_that_is_worth_one(motion):
    for signal in SIGNALS:
        assert units_of(signal, motion)[signal_unit(signal, motion)] == 1.0
        assert unit_in(signal_unit(signal), motion) == signal_unit(signal, motion)


@pytest.mark.parametrize("unit", ["rad/s2", "rad/s^2", "rad/s²"])
def test_a_power_may_be_written_in_any_way(unit):
    assert usual_spelling(unit) == "rad/s^2"
    assert [usual_spelling(f"kg m{power}/A") for power in ("2", "^2", "²")] == ["kg m^2/A"] * 3


def test_other_units_are_spelt_as_they_are():
    assert [usual_spelling(unit) for unit in ALL_UNITS] == [*ALL_UNITS]


def test_a_gain_turns_a_voltage_into_a_force(tmp_path):
    signals = {"motor_torque": "{columns: [u], unit: V, gain: {value: 35.0, unit: N/V}}"}
    recording = read(tmp_path, signals, "t,u", ["0,1.0", "0.001,2.5"], "linear")
    assert np.allclose(recording.signals["motor_torque"], [35.0, 87.5])
    assert recording.metadata["motion"] == "linear"


@pytest.mark.parametrize(
    ("signal", "column", "said"),
    [
        ("speed", "unit: V", "'V' is no unit of the speed of a rotary machine; use one of rad/s"),
        ("motor_position", "unit: mm", "'mm' is no unit of the motor position of a rotary machine"),
        ("current", "unit: Amp", "'Amp' is not possible"),
        ("motor_torque", "unit: V, gain: {value: 2.0, unit: N/V}", "'N/V' is not possible"),
        ("motor_torque", "unit: V, gain: 2.0", "give value, unit"),
    ],
)
def test_a_unit_that_does_not_measure_the_signal_is_refused(tmp_path, signal, column, said):
    with refused_in_one_line(tmp_path / "own.yaml", f"signals.{signal}", said):
        read(tmp_path, {signal: f"{{columns: [u], {column}}}"}, "t,u", ["0,1.0", "0.001,2.5"])


def test_a_carriage_has_no_counts_per_revolution(tmp_path):
    with pytest.raises(InputError, match="has no revolutions"):
        counter = {"motor_position": "{columns: [u], counts_per_revolution: 10}"}
        read(tmp_path, counter, "t,u", ["0,1", "1,2"], "linear")

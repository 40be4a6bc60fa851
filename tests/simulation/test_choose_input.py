"""What drives a twin: a recording without a drive's signal is refused with what to map."""

import pytest

from ema_bench_replay.errors import InputError
from ema_bench_replay.load import load
from ema_twin_sim.measured.observe import observe
from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.simulate import choose_input
from ema_twin_sim.simulation.virtual_bench import virtual_bench
from tests.recorded import with_signals


def test_a_recording_without_a_current_is_told_what_to_map_and_no_option_it_never_gave(stock):
    bench = virtual_bench(stock, parse_command("sine:0.02:1"), 0.1, name="run", seed=1)
    alone = with_signals(bench, {"motor_position": bench.signals["motor_position"]})
    with pytest.raises(InputError) as refused:
        choose_input(alone, stock)
    said = str(refused.value)
    assert said.startswith("run: has no current and no torque of the drive") and "--input" not in said
    assert "current or motor_torque" in said and "`gain`" in said
    with pytest.raises(InputError, match="--input setpoint"):
        choose_input(alone, stock, "setpoint")


@pytest.mark.parametrize("judge", [choose_input, observe])
def test_a_column_of_the_map_that_the_file_lacks_is_named(stock, tmp_path, judge):
    (tmp_path / "own.yaml").write_text(
        "version: 1\ntime: {column: '^t$', unit: s}\nsignals:\n"
        "  motor_torque: {columns: [tau], unit: N m}\n  motor_position: {columns: [q], unit: rad}\n"
    )
    (tmp_path / "run.csv").write_text("\n".join(["t,q,torq", *(f"{row}.5,{row}.5,1.5" for row in range(99)), ""]))
    recording = load(tmp_path / "run.csv", import_map=tmp_path / "own.yaml")
    with pytest.raises(InputError, match=r"run: has no current.*run.csv has no column 'tau' .*'own' .* in the map"):
        judge(recording, stock)

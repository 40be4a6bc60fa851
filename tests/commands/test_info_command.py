"""`info` of a recording: its JSON holds what describes it, no notes that the program keeps for itself."""

import json

from ema_bench_replay.load import load
from ema_bench_replay.recording import LACKED
from ema_twin_sim.commands.info import run as info


def test_the_columns_that_a_file_lacks_are_no_part_of_its_metadata(tmp_path):
    (tmp_path / "own.yaml").write_text(
        "version: 1\ntime: {column: '^t$', unit: s}\nsignals:\n"
        "  motor_torque: {columns: [tau], unit: N m}\n  motor_position: {columns: [q], unit: rad}\n"
    )
    (tmp_path / "run.csv").write_text("t,q\n" + "".join(f"{row}.5,{row}.0\n" for row in range(5)))
    own = str(tmp_path / "own.yaml")
    assert any(key.endswith(LACKED) for key in load(tmp_path / "run.csv", import_map=own).metadata)
    info(str(tmp_path / "run.csv"), import_map=own, json=tmp_path / "run.json")
    metadata = json.loads((tmp_path / "run.json").read_text())["metadata"]
    assert metadata and not any(key.endswith(LACKED) for key in metadata)

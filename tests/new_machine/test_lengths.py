"""A rotary motor that moves a nut, measured in a unit of length: the way that init tells to use it."""

import numpy as np
import pytest

from ema_bench_replay.load import load
from tests.command_line import done
from tests.trace_text import write_columns

TIME = np.arange(3000) * 2e-3
LEAD = 0.005  # m
ANGLE = 20.0 * (1.0 - np.cos(3.0 * TIME))
CURRENT = 0.5 * np.sign(np.sin(3.0 * TIME)) + 0.3 * np.cos(3.0 * TIME)


@pytest.mark.parametrize(("unit", "size"), [("um", 1e-6), ("mm", 1e-3)])
def test_a_nut_behind_a_screw_is_read_as_told(unit, size, drafted, tmp_path):
    name = f"output position [{unit}]"
    nut = np.round(ANGLE * LEAD / (2.0 * np.pi) / size, 3)
    columns = {"time [s]": TIME, name: nut, "motor position [mrad]": 1e3 * ANGLE, "motor current [A]": CURRENT}
    draft = drafted(columns)
    assert f"with {2.0 * np.pi * size:.6g} divided by the screw's lead in m as its factor" in draft.said
    line = draft.said.split("add the line `")[1].split("`")[0]
    line = line.replace("…", f"{2.0 * np.pi * size / LEAD:.8g}")
    map_file, model = tmp_path / "m_map.yaml", tmp_path / "m.yaml"
    map_file.write_text(draft.map.replace("signals:\n", f"signals:\n  {line}\n"))
    trace = write_columns(tmp_path / "run0.csv", columns)
    recording = load(trace, import_map=map_file)
    assert np.allclose(recording.signals["output_position"], ANGLE, atol=1e-3 * np.ptp(ANGLE))
    assert "output position" in done("compare", trace, "--map", map_file, "--model", model).stdout


def test_a_force_of_a_rotary_machine_is_no_length(drafted):
    columns = {"time [s]": TIME, "motor position [rad]": ANGLE, "motor current [A]": CURRENT, "force [N]": CURRENT}
    assert "screw" not in drafted(columns).said

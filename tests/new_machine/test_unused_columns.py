"""`init` reads imperial units, and says why columns that may be meant are not used."""

import numpy as np

from ema_twin_sim.commands.init import run as init
from tests.trace_text import write_columns

TIME = np.arange(800) * 2e-3
SPEED = 3.0 * np.cos(3.0 * TIME)
FORCE = 80.0 * np.sign(SPEED) - 2.0 * np.sin(3.0 * TIME)


def drafted(tmp_path, capsys, columns):
    init(str(tmp_path / "m"), [write_columns(tmp_path / "run.csv", {"time (s)": TIME, **columns})])
    return " ".join(capsys.readouterr().out.split()), (tmp_path / "m_map.yaml").read_text()


def test_a_machine_in_inches_and_pounds_is_linear(tmp_path, capsys):
    columns = {"displacement (in)": np.sin(3.0 * TIME), "velocity (in/s)": SPEED, "actuator force (lb)": FORCE}
    said, text = drafted(tmp_path, capsys, columns)
    assert "motion: linear" in text and "displacement (in) → motor_position in in" in said
    for line in ("unit: in}", "unit: in/s}", "unit: lbf}"):
        assert line in text
    assert "CHECK" not in "\n".join(text.splitlines()[1:])


def test_reasons_are_given(tmp_path, capsys):
    columns = {"position (mm)": np.sin(3.0 * TIME), "velocity (mm/s)": SPEED, "force (N)": FORCE}
    more = {"efficiency (%)": SPEED**2, "strain (ustrain)": FORCE, "power (W)": FORCE, "clamp force (kip)": SPEED}
    said, _ = drafted(tmp_path, capsys, {**columns, **more})
    assert "no signal is given in these units: efficiency (%), strain (ustrain) (if one is a signal" in said
    assert "other columns are read in their place: clamp force (kip) (if one is meant" in said
    assert "power (W)" not in said


def test_many_are_counted(tmp_path, capsys):
    columns = {"position (mm)": np.sin(3.0 * TIME), "force (N)": FORCE}
    said, _ = drafted(tmp_path, capsys, {**columns, **{f"share_{k} (%)": FORCE for k in range(10)}})
    assert "share_7 (%) and 2 more (if one" in said

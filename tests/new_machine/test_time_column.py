"""The time column is known by its name, or by a unit of time if it goes in even steps."""

import numpy as np
import pytest

from ema_twin_sim.commands.init import run as init
from ema_twin_sim.new_machine.columns import guess_columns
from tests.trace_text import write_columns

POINTS = np.arange(1.0, 31.0)
SLIPS = 0.1 * 1.3**POINTS  # in uneven steps, as the load rises


@pytest.mark.parametrize("name", ["轉差 s", "slip [s]", "轉差[s]"])
def test_what_has_a_unit_of_time_but_goes_in_uneven_steps_is_no_clock(tmp_path, capsys, name):
    columns = {"轉速rpm": 3600.0 - 20.0 * POINTS, name: SLIPS, "電流A": 3.0 + 0.5 * POINTS}
    init(str(tmp_path / "m"), [write_columns(tmp_path / "points.csv", columns)])
    told = " ".join(capsys.readouterr().out.split())
    assert "電流A → current in A" in told and "轉速rpm → speed in rpm" in told
    assert "No time column was found: each row is read as an operating point" in told
    assert "operating_points: true" in (tmp_path / "m_map.yaml").read_text()


@pytest.mark.parametrize("name", ["時間 s", "时间s", "time [s]", "время [s]", "[s]"])
def test_a_name_of_the_time_is_the_clock_however_it_goes(name):
    columns = {name: SLIPS, "電流A": POINTS}
    assert guess_columns(list(columns), numbers=columns).time.column == name


@pytest.mark.parametrize("name", ["轉差 s", "run [s]", "採樣ms"])
def test_a_unit_of_time_and_even_steps_are_a_clock(name):
    columns = {name: 0.5 * POINTS, "電流A": POINTS}
    assert guess_columns(list(columns), numbers=columns).time.column == name

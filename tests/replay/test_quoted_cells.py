"""Marks inside quoted words separate no cells; those of quoted numbers belong to the numbers."""

import numpy as np
import pytest

from ema_bench_replay.traces.quoted_cells import with_marks_hidden, with_marks_shown
from tests.trace_text import read_text


@pytest.mark.parametrize("mark", [",", ";", "\t"])
def test_names_may_hold_the_separator(tmp_path, mark):
    names = [f"Time{mark} relative [s]", f"Speed{mark} motor [rpm]", "Current [A]"]
    rows = "".join(mark.join((f"{k * 0.01:.2f}", f"{k}.5", "-0.1")) + "\n" for k in range(20))
    table = read_text(tmp_path, mark.join(f'"{name}"' for name in names) + "\n" + rows)
    assert table.header == names
    assert np.array_equal(table.columns[1], np.arange(20) + 0.5)


def test_words_in_rows_may_hold_the_separator(tmp_path):
    rows = "".join(f'{k * 0.01:.2f},"moving, fast",{k}\n' for k in range(20))
    table = read_text(tmp_path, f"time [s],state,position [rad]\n{rows}", needed=lambda header: (0, 2))
    assert np.array_equal(table.columns[2], np.arange(20))


def test_quoted_numbers_keep_their_decimal_commas(tmp_path):
    rows = "".join(f'"{k},5","{k * 2},25"\n' for k in range(20))
    table = read_text(tmp_path, f'"time [s]","speed, of the motor [rpm]"\n{rows}')
    assert table.header[1] == "speed, of the motor [rpm]"
    assert np.array_equal(table.columns[1], np.arange(20) * 2 + 0.25)


def test_a_mark_for_inches_opens_no_quotation(tmp_path):
    rows = "".join(f"{k * 0.01:.2f},{k},{k}\n" for k in range(20))
    table = read_text(tmp_path, f'time [s],stroke 5",stroke 3"\n{rows}')
    assert len(table.header) == 3


def test_what_is_hidden_is_shown_as_written():
    written = b'1;"a;b,\tc";"1,5"\n'
    hidden = with_marks_hidden(written)
    assert hidden.count(b";") == 2 and b'"1,5"' in hidden
    assert with_marks_shown(hidden.decode()) == written.decode()

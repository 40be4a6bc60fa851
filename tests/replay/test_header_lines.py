"""What stands between a text's header and its rows is skipped."""

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_bench_replay.traces.trace_table import read_table

ROWS = "0,1;1,5;2,5\n0,2;1,6;2,5\n0,3;1,7;2,5\n"
BETWEEN = {
    "a blank line": "\n",
    "a comment": "# rows follow\n",
    "an odd line": "Run 3; of today\n",
    "units of some": "Unit: s; rad\n",
    "all of these": "\nRun 3; of today\n% more\n\n",
}


@pytest.mark.parametrize("kind", BETWEEN)
@pytest.mark.parametrize("above", ["", "Recorder 7\n", "# made today\n\n"])
def test_the_rows_begin_where_numbers_do(tmp_path, kind, above):
    """A header that was found above such a line ended in a refusal of that line."""
    path = tmp_path / "run.csv"
    path.write_text(f"{above}t;pos;cur\n{BETWEEN[kind]}{ROWS}")
    table = read_table(path)
    assert table.header == ["t", "pos", "cur"] and table.warnings == ()
    assert np.array_equal(table.columns[0], [0.1, 0.2, 0.3]) and np.array_equal(table.columns[1], [1.5, 1.6, 1.7])
    line = path.read_text().split("\n")[table.line(0) - 1]
    assert line == "0,1;1,5;2,5"


@pytest.mark.parametrize("kind", ["a blank line", "a comment"])
def test_columns_between_blanks_too(tmp_path, kind):
    (tmp_path / "run.txt").write_text("t  pos  cur\n" + BETWEEN[kind] + "0.1  1.5  2.5\n0.2  1.6  2.5\n")
    table = read_table(tmp_path / "run.txt")
    assert table.header == ["t", "pos", "cur"] and np.array_equal(table.columns[0], [0.1, 0.2])


@pytest.mark.parametrize("torn", ["0,05\n", "0,05;\n", "\n0,05\n"])
def test_a_first_row_that_is_cut_is_not_skipped(tmp_path, torn):
    (tmp_path / "run.csv").write_text(f"t;pos;cur\n{torn}{ROWS}")
    with pytest.raises(InputError, match=r"line \d: "):
        read_table(tmp_path / "run.csv")

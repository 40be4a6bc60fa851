"""A column beside the signals that begins late or ends early takes no rows from what ``init`` looks at."""

import numpy as np
import pytest

from ema_bench_replay.errors import InputError

TIME = np.arange(400) * 5e-3


def motion(empty):
    """A motion with a light sensor and a door switch; ``empty`` are the rows in which a column's cells are."""
    columns = {
        "time [s]": TIME,
        "motor position [rad]": np.sin(3.0 * TIME),
        "current [A]": np.sign(np.cos(3.0 * TIME)) + 0.1 * np.cos(9.0 * TIME),
        "light": 20.0 + np.sin(0.5 * TIME),
        "door": 7.0 + np.cos(0.4 * TIME),
    }
    for name, rows in empty.items():
        columns[name] = ["" if k in rows else value for k, value in enumerate(columns[name])]
    return columns


@pytest.mark.parametrize("empty", [{"light": range(320, 400)}, {"light": range(310, 400), "door": range(99)}])
def test_columns_that_are_no_signals_cut_nothing(drafted, read, empty):
    draft = drafted(motion(empty))
    assert f"light: {len(empty['light'])} of 400 cells hold no number" in draft.said
    assert "current [A] → current in A" in draft.said and "left out" not in draft.warned
    assert len(read().time) == 400


def test_signals_do_and_it_is_told(drafted, read):
    draft = drafted(motion({"current [A]": range(340, 400), "light": range(310, 400), "door": range(50)}))
    assert "the last 60 rows are left out" in draft.warned and "light: 30 of 340 cells" in draft.said
    assert len(read().time) == 340


def test_signals_that_lack_more_at_both_ends_together_are_refused(drafted):
    lacking = r"current \[A\], motor position \[rad\]: without these nothing is left to read"
    with pytest.raises(InputError, match=lacking):
        drafted(motion({"current [A]": range(340, 400), "motor position [rad]": range(60)}))

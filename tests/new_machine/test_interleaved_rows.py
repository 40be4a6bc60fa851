"""`init` refuses traces in which the rows of several motors take turns, and names the column that tells them apart."""

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from tests.trace_text import write_columns

TIME = np.arange(800) * 0.02


def turns(names, *, same_time):
    """Rows of two motors in turn, each with its own angle, at the same times or one after the other."""
    time = np.repeat(TIME, 2) + (0.0 if same_time else np.tile([0.0, 0.007], len(TIME)))
    angles = [np.sin(2.0 * TIME), 3.0 + np.cos(1.3 * TIME)]
    torques = [np.cos(2.0 * TIME), -np.sin(1.3 * TIME)]
    return {
        "time": np.round(time, 4),
        "motor": np.tile(names, len(TIME)),
        "position [rad]": np.round(np.stack(angles, 1).ravel(), 5),
        "torque [N m]": np.round(np.stack(torques, 1).ravel(), 5),
    }


@pytest.mark.parametrize("same_time", [True, False])
@pytest.mark.parametrize("names", [[1, 2], ["left", "right"]])
def test_rows_of_two_motors_are_refused(names, same_time, drafted):
    """Two motors on a bus were read as one, whose position was said to have nothing in common with its speed."""
    said = rf"column 'motor' tells 2 parts apart \({names[0]}, {names[1]}\), and their rows take turns: write the rows"
    with pytest.raises(InputError, match=said):
        drafted(turns(names, same_time=same_time))


def test_rows_in_turn_are_refused_in_any_trace_that_is_given(drafted):
    """Only the first trace was looked at."""
    both = turns([1, 2], same_time=False)
    one = {name: column[::2] for name, column in both.items()}
    with pytest.raises(InputError, match=r"run1\.csv: column 'motor' tells 2 parts apart"):
        drafted(one, both)


LEFT_OR_RIGHT = r"column 'motor' tells 2 parts apart \(left, right\)"


@pytest.mark.parametrize(("encoding", "mark"), [("utf-16", ","), ("cp1252", ";"), ("utf-8", "\t"), ("utf-8", "   ")])
def test_names_of_motors_are_read_as_the_trace_is(encoding, mark, drafted, tmp_path):
    """In UTF-16 the motors were called x00l and so on, and between blanks nobody saw their names."""
    trace = write_columns(tmp_path / "both.txt", turns(["left", "right"], same_time=True), mark, encoding)
    with pytest.raises(InputError, match=LEFT_OR_RIGHT):
        drafted(trace)


@pytest.mark.parametrize("comment", ['"hit', '5" pipe', "x" * 140_000, '"two\nlines"'])
def test_a_comment_hides_no_names(comment, drafted):
    """A long cell ended init with an internal error, and a stray quotation mark hid all rows below it."""
    columns = turns(["left", "right"], same_time=True)
    with pytest.raises(InputError, match=LEFT_OR_RIGHT):
        drafted({**columns, "comment": [*["ok"] * 5, comment, *["ok"] * 1594]})


def test_a_column_that_alternates_beside_one_motion_tells_nothing_apart(drafted):
    angle = np.round(np.sin(2.0 * TIME), 5)
    columns = {"time [s]": TIME, "tick": np.arange(len(TIME)) % 4, "position [rad]": angle}
    columns["torque [N m]"] = np.round(np.cos(2.0 * TIME), 5)
    assert "position [rad] → motor_position" in drafted(columns).said
    with pytest.raises(InputError, match=r"time repeats .* more decimals or, if rows of several parts"):
        drafted({**columns, "time [s]": np.floor(TIME / 0.08) * 0.08})


def test_comments_at_random_tell_nothing_apart(drafted):
    words = np.random.default_rng(4).choice(["", "ok", "Pause"], len(TIME))
    columns = {"time [s]": TIME, "comment": words, "position [rad]": np.round(np.sin(2.0 * TIME), 1)}
    columns["torque [N m]"] = np.round(np.cos(2.0 * TIME), 5)
    assert "position [rad] → motor_position" in drafted(columns).said

"""Of many names a message shows the first few, so that its sentence stays whole."""

import pytest

from ema_bench_replay.load import load
from ema_bench_replay.some_of import some_of
from tests.one_line import refused_in_one_line


@pytest.mark.parametrize(
    ("names", "shown"),
    [
        (["a"], "a"),
        (["a", "b"], "a, b"),
        (["left speed", "right speed", "bus"], "left speed and 2 more"),
        (["the column with the longest name of all", "b"], "the column with the… and 1 more"),
        ([], ""),
    ],
)
def test_as_many_as_go_into_the_length(names, shown):
    assert some_of(names, 20) == shown


def test_a_file_of_many_columns_is_refused_in_a_whole_sentence(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(",".join(f"left wheel signal {k}" for k in range(60)) + "\n" + ",".join("1" * 60) + "\n")
    with refused_in_one_line(path, "among left wheel signal 0, left wheel signal 1 and 5", "with its time axis"):
        load(path)

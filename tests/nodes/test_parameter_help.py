"""A node's --help tells its parameters with default, range and unit, and does not start it."""

import pytest

from ema_bench_replay.nodes import record, replay
from ema_bench_replay.nodes.spin import run


@pytest.mark.parametrize(
    ("node", "told"),
    [
        (record, ("topics: topics to record", "(default *)", "record --ros-args -p output:=PATH")),
        (replay, ("patience: longest time to wait for those readers (default 5.0; 0 to 3600 s)", "one of exit, wait")),
    ],
    ids=["record", "replay"],
)
def test_help_tells_the_parameters(node, told, capsys):
    def make():
        raise AssertionError("the node was started")

    name = node.__name__.rpartition(".")[2]
    assert run(make, node.PARAMETERS, [f"/somewhere/{name}", "--help"]) == 0
    printed = capsys.readouterr().out
    for words in told:
        assert words in printed

"""A named pipe in place of a recording is refused at once: to open it would wait for its writer for ever."""

import os

import pytest

from ema_bench_replay.errors import InputError
from ema_bench_replay.load import load
from ema_twin_sim.commands.inputs import load_runs


@pytest.mark.parametrize("name", ["run.csv", "run.mcap"])
@pytest.mark.parametrize("read", [load, lambda path: load_runs([path])])
def test_a_pipe_is_refused(tmp_path, name, read):
    os.mkfifo(tmp_path / name)
    with pytest.raises(InputError, match=f"{name}: is a pipe, not a file; write its content to a file"):
        read(tmp_path / name)

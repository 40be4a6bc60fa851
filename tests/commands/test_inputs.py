"""What is wrong with recordings is told once for all of them, when they are read."""

import errno
import tempfile

import pytest
import typer

from ema_bench_replay.errors import InputError
from ema_twin_sim.commands.inputs import find_recordings, load_runs, refuse_inputs
from ema_twin_sim.commands.options import of_json
from ema_twin_sim.listing import by_recording

MAP = """version: 1
time: {column: t, unit: s}
signals:
  current: {columns: [i], unit: A}
  speed: {columns: [w], unit: rad/s}
"""


def written(folder, *names):
    """Traces without the speed that their map names, and that map."""
    (folder / "map.yaml").write_text(MAP)
    for name in names:
        (folder / name).write_text("t,i\n0.0,1.0\n0.1,2.0\n0.2,1.0\n")
    return [folder / name for name in names], str(folder / "map.yaml")


def test_the_same_warning_of_several_recordings_is_told_once(tmp_path, capsys):
    files, map_file = written(tmp_path, "a.csv", "b.csv", "c.csv")
    load_runs(files, import_map=map_file)
    (told,) = (line for line in capsys.readouterr().err.splitlines() if "reads the speed" in line)
    assert told.startswith(
        "warning: a.csv, b.csv and c.csv: the map 'map' reads the speed from 'w', which is not there"
    )


def test_a_folder_of_text_traces_stands_for_those_in_csv_or_else_for_the_others(tmp_path):
    others, _ = written(tmp_path, "a.txt", "b.dat")
    told = []
    assert find_recordings(tmp_path, told.append) == others
    assert told == [f"{tmp_path}: holds no .csv or .mcap file; reading its 2 .dat and .txt files instead"]
    traces, _ = written(tmp_path, "c.CSV", "d.csv")
    assert find_recordings(tmp_path) == traces


def test_notes_beside_a_bag_of_another_kind_are_no_recording(tmp_path):
    """A folder of an SQLite bag with a README.txt in it was refused for the README, which has no time column."""
    for name in ("metadata.yaml", "a_0.db3", "README.txt"):
        (tmp_path / name).write_text("how this was recorded\n")
    assert find_recordings(tmp_path) == [tmp_path]
    with pytest.raises(InputError, match=r"a_0\.db3 is no plain MCAP; convert it: pip install rosbags"):
        load_runs([tmp_path])


def test_a_strict_reader_refuses_the_first(tmp_path):
    files, map_file = written(tmp_path, "a.csv", "b.csv")
    with pytest.raises(InputError, match=r"^a\.csv: the map .*--strict"):
        load_runs(files, import_map=map_file, strict=True)


def test_of_many_recordings_some_are_named():
    many = [f"run_{k}.csv: cut" for k in range(9)]
    assert by_recording([*many, "run_0.csv: late"]) == [
        "run_0.csv, run_1.csv, run_2.csv, run_3.csv and 5 more: cut",
        "run_0.csv: late",
    ]
    assert by_recording(many[:5])[0].endswith("run_3.csv and run_4.csv: cut")


def test_an_output_that_is_a_folder_is_refused_before_anything_is_computed(tmp_path):
    with pytest.raises(InputError, match="is a folder; name a file"):
        refuse_inputs([], None, tmp_path)
    refuse_inputs([], None, tmp_path / "new.yaml", folder=tmp_path)
    with pytest.raises(typer.BadParameter, match="is a folder; name a file"):
        of_json(tmp_path)


@pytest.mark.parametrize(
    ("error", "remedy"),
    [
        (
            PermissionError(errno.EACCES, "Permission denied"),
            "(Permission denied); choose a folder with write permission",
        ),
        (OSError(errno.EROFS, "Read-only file system"), "; choose a folder with write permission"),
        (OSError(errno.ENOSPC, "No space left on device"), "(No space left on device); choose another folder"),
    ],
)
def test_the_remedy_for_an_output_fits_its_reason(tmp_path, monkeypatch, error, remedy):
    def refuse(dir):
        raise error

    monkeypatch.setattr(tempfile, "TemporaryFile", refuse)
    with pytest.raises(InputError) as told:
        refuse_inputs([], tmp_path / "new.yaml")
    assert remedy in str(told.value)

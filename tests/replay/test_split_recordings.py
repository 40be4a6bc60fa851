"""A recording in several files: how it is split, and that it is read as one."""

import shutil
from dataclasses import replace

import pytest
import yaml
from rosbags.highlevel import AnyReader

from ema_bench_replay.bags.bag_reader import read_bag
from ema_bench_replay.bags.stream_writer import StreamWriter
from ema_bench_replay.load import load
from ema_bench_replay.nodes.record import PARAMETERS
from ema_twin_sim.commands.inputs import load_runs
from tests.bags import assert_same, listed_in, refused, some_samples, write_other
from tests.launch_files import started
from tests.nodes.test_recorder_faults import TOPIC, Bench

PARTS = ("live.mcap", "live_1.mcap", "live_2.mcap", "live_3.mcap")


def recorded(folder, count=3500, **limits):
    """The folder of a recording of 1 kHz, after its last sample."""
    bench = Bench(StreamWriter(folder, **limits))
    for _ in range(0, count, 500):
        bench.send(500)
    assert bench.writer.finish() == {TOPIC: count} and bench.writer.lost == {TOPIC: 0}
    return folder


@pytest.fixture
def split(tmp_path):
    return recorded(tmp_path / "split" / "live", max_duration=1.0)


@pytest.fixture
def plain(tmp_path):
    return load(recorded(tmp_path / "plain" / "live"))


class TestWriting:
    def test_by_time(self, split):
        content = listed_in(split)
        assert content["relative_file_paths"] == list(PARTS) == [file["path"] for file in content["files"]]
        assert all(0.8e9 < file["duration"]["nanoseconds"] <= 1e9 for file in content["files"][:-1])
        assert sum(file["message_count"] for file in content["files"]) == content["message_count"] == 3500
        assert content["duration"]["nanoseconds"] == 3499 * 1_000_000

    def test_by_size(self, tmp_path):
        most = 30_000
        folder = recorded(tmp_path / "live", max_size=most)
        sizes = [path.stat().st_size for path in folder.glob("*.mcap")]
        assert len(sizes) > 2 and max(sizes) < 2 * most
        assert len(load(folder)) == 3500

    def test_other_tools_read_all_of_it(self, split):
        with AnyReader([split]) as reader:
            numbers = [reader.deserialize(data, c.msgtype).sequence for c, _, data in reader.messages()]
        assert numbers == list(range(3500))


class TestReading:
    def test_a_folder_is_one_recording(self, split, plain):
        assert_same(load(split), plain)
        assert [len(recording) for recording in load_runs([split])] == [3500]

    def test_a_list_of_its_files_is_one_recording(self, split, plain):
        (one,) = load_runs([split / name for name in reversed(PARTS)])
        assert_same(one, plain)

    def test_its_files_where_other_recordings_lie_too(self, split, plain, tmp_path):
        other = write_other(tmp_path / "other.mcap", some_samples())
        shutil.copy(other, split / "other.mcap")
        (split / "metadata.yaml").unlink()
        found = load_runs([split])
        assert [(recording.name, len(recording)) for recording in found] == [("live", 3500), ("other", 50)]
        refused(split, "5 .mcap files", "other.mcap")

    def test_a_folder_given_beside_one_of_its_files(self, split, capsys):
        (one,) = load_runs([split / PARTS[1], split])
        assert len(one) == 3500
        assert "given more than once" in capsys.readouterr().err

    def test_one_file_of_it_alone(self, split):
        (one,) = load_runs([split / PARTS[1]])
        assert 900 <= len(one) <= 1000 and "begins with sample" in one.warnings[0]

    def test_a_part_that_is_missing_is_told(self, split):
        (split / PARTS[2]).unlink()
        recording = load(split)
        assert 2500 <= len(recording) <= 2600
        assert recording.warnings == (
            f"live.mcap to live_3.mcap: {TOPIC}: {3500 - len(recording)} samples are missing",
        )

    def test_a_recorder_that_was_killed(self, tmp_path):
        """It wrote no metadata.yaml, and its last file has no index."""
        bench = Bench(StreamWriter(tmp_path / "live", max_duration=1.0))
        bench.send(2500)
        recording = load(tmp_path / "live")
        assert len(recording) == 2500
        assert recording.warnings == ("live_2.mcap: the file is cut, so only what is before that can be used",)

    @pytest.mark.parametrize("ended", [True, False])
    def test_one_of_rosbag2(self, tmp_path, ended):
        """It numbers its files from 0 on, and lists them where it ends well."""
        folder = tmp_path / "rosbag2_live"
        folder.mkdir()
        samples, names = some_samples(1100), [f"rosbag2_live_{k}.mcap" for k in range(11)]
        for k, name in enumerate(names):
            write_other(folder / name, samples[100 * k : 100 * k + 100])
        if ended:
            content = {"rosbag2_bagfile_information": {"relative_file_paths": names}}
            (folder / "metadata.yaml").write_text(yaml.safe_dump(content))
        whole = read_bag(write_other(tmp_path / "rosbag2_live.mcap", samples))
        assert_same(load(folder), whole.from_zero())
        assert_same(read_bag([folder / name for name in names]), replace(whole, name="rosbag2_live"))

    def test_recordings_that_are_numbered_stay_several(self, tmp_path):
        for k in (1, 2, 3):
            write_other(tmp_path / f"ramp_{k}.mcap", some_samples(50 + k))
        assert [len(recording) for recording in load_runs([tmp_path])] == [51, 52, 53]


def test_the_launch_file_hands_on_how_to_split():
    (record,) = (
        node
        for node in started("ema_twin", record="bag", max_bagfile_size="1000", max_bagfile_duration="60")
        if node["executable"] == "record"
    )
    limits = {"max_bagfile_size": 1000, "max_bagfile_duration": 60.0}
    assert record["parameters"] == [{"output": "bag", **limits}]
    assert limits.keys() < {declaration.name for declaration in PARAMETERS}

"""Bags: exact both ways, open to every tool, and written whole or not at all."""

import math
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as nps
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader

from ema_bench_replay.bags.bag_reader import read_bag
from ema_bench_replay.bags.bag_writer import write_bag, write_mcap
from ema_bench_replay.bags.definitions import message_definition
from ema_bench_replay.bags.stream_writer import StreamWriter
from ema_bench_replay.errors import InputError
from ema_bench_replay.load import load
from ema_bench_replay.recording import SIGNALS, Recording
from tests.bags import DEFINITION, a_recording, assert_same, listed_in, summary_of
from tests.command_line import ENDING


class TestRoundTrip:
    def test_what_was_written_is_read(self, bag, mcap):
        assert_same(read_bag(bag), a_recording())
        assert_same(load(mcap), a_recording().from_zero())

    @given(
        st.integers(1, 60).flatmap(
            lambda n: st.tuples(
                nps.arrays(np.int64, n, elements=st.integers(1, 4_000_000_000)),
                st.dictionaries(
                    st.sampled_from(SIGNALS),
                    nps.arrays(np.float64, n, elements=st.floats(allow_nan=False, allow_infinity=False)),
                    min_size=1,
                ),
            )
        ),
        st.integers(0, 2**31 * 10**9 - 10**12),
        st.floats(-1e6, 1e6),
    )
    @pytest.mark.slow
    @settings(max_examples=60, deadline=None)
    def test_any_recording(self, tmp_path_factory, parts, start, origin):
        steps, signals = parts
        recording = Recording("any", np.cumsum(steps) - steps[0], signals, start, origin)
        folder = tmp_path_factory.mktemp("any")
        assert_same(read_bag(write_bag(recording, folder)), recording)

    def test_a_trace_and_its_bag_are_the_same(self, traces, tmp_path):
        for path in traces:
            recording = load(path)
            rows = len(path.read_bytes().splitlines()) - 1
            assert len(recording) == rows
            assert_same(load(write_bag(recording, tmp_path)), recording)

    def test_without_positions_there_are_no_joints(self, tmp_path):
        recording = a_recording(signals={"current": np.zeros(1200)})
        folder = write_bag(recording, tmp_path)
        channels = summary_of(folder / "run.mcap").channels.values()
        assert [channel.topic for channel in channels] == ["/bench/state"]

    def test_parts_of_a_recording(self, tmp_path):
        part = a_recording().between(0.5, 1.0)
        assert len(part) == 251 and part.start == a_recording().start + 500_000_000
        position = a_recording().signals["motor_position"]
        assert part.motor_angle_origin == -math.pi + position[250]
        assert np.array_equal(part.signals["motor_position"], position[250:501] - position[250])
        assert_same(load(write_bag(part, tmp_path)), part)
        with pytest.raises(InputError, match="no sample from 7 s to"):
            a_recording().between(7.0, 8.0)


class TestFormat:
    """What other tools look for in the file."""

    def test_profile_channels_and_chunks(self, mcap):
        with mcap.open("rb") as file:
            reader = make_reader(file)
            assert reader.get_header().profile == "ros2"
            summary = reader.get_summary()
            metadata = {record.name: record.metadata for record in reader.iter_metadata()}
        topics = {channel.topic: channel for channel in summary.channels.values()}
        assert set(topics) == {"/bench/state", "/bench/joint_states"}
        for channel in topics.values():
            schema = summary.schemas[channel.schema_id]
            assert channel.message_encoding == "cdr" and schema.encoding == "ros2msg"
            [qos] = yaml.safe_load(channel.metadata["offered_qos_profiles"])
            assert qos["reliability"] == "reliable" and qos["deadline"]["sec"] == 9223372036
        assert summary.schemas[topics["/bench/state"].schema_id].data.decode() == DEFINITION
        counts = {topic: summary.statistics.channel_message_counts[topics[topic].id] for topic in topics}
        assert counts == {"/bench/state": 1200, "/bench/joint_states": 240}
        assert all(chunk.compression == "zstd" for chunk in summary.chunk_indexes)
        assert max(chunk.message_end_time - chunk.message_start_time for chunk in summary.chunk_indexes) <= 10**9
        assert metadata["ema_twin"]["source"] == "run.CSV"
        assert metadata["ema_twin"]["signals"] == "current speed motor_position output_position"

    def test_chunks_stay_short_across_gaps(self, tmp_path):
        stamps = np.cumsum(np.r_[0, np.full(900, 1_300_000), 7_700_000_001, np.full(30_000, 100_000)])
        recording = a_recording(stamps=stamps, signals={"motor_position": np.arange(len(stamps)) / 7})
        folder = write_bag(recording, tmp_path)
        assert_same(load(folder), recording)
        chunks = summary_of(folder / "run.mcap").chunk_indexes
        assert max(chunk.message_end_time - chunk.message_start_time for chunk in chunks) <= 10**9

    def test_metadata_yaml(self, bag):
        content = listed_in(bag)
        assert content["version"] == 9 and content["storage_identifier"] == "mcap"
        assert content["message_count"] == 1440 and content["relative_file_paths"] == ["run.mcap"]
        assert content["starting_time"]["nanoseconds_since_epoch"] == a_recording().start
        assert content["duration"]["nanoseconds"] == 1199 * 2_000_000
        for topic in content["topics_with_message_count"]:
            assert topic["topic_metadata"]["offered_qos_profiles"][0]["liveliness"] == "automatic"

    def test_mcap_library_decodes_it(self, mcap):
        with mcap.open("rb") as file:
            messages = list(make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages())
        recording = a_recording()
        states = [m for _, channel, _, m in messages if channel.topic == "/bench/state"]
        assert [m.sequence for m in states] == list(range(1200)) and {m.run for m in states} == {1}
        assert [m.current for m in states] == recording.signals["current"].tolist()
        assert all(math.isnan(m.voltage) for m in states) and states[0].motor_angle_origin == -math.pi
        stamps = [m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for m in states]
        assert stamps == (recording.stamps + recording.start).tolist() and states[0].header.frame_id == "bench"
        joints = [m for _, channel, _, m in messages if channel.topic == "/bench/joint_states"]
        assert joints[1].name == ["motor", "output"]
        assert list(joints[1].position) == [recording.signals[f"{n}_position"][5] for n in joints[1].name]
        assert joints[1].velocity[0] == recording.signals["speed"][5] and math.isnan(joints[1].velocity[1])

    def test_rosbags_reads_the_folder(self, bag):
        with AnyReader([bag]) as reader:
            assert reader.message_count == 1440 and reader.start_time == a_recording().start
            read = [
                reader.deserialize(data, connection.msgtype)
                for connection, _, data in reader.messages()
                if connection.topic == "/bench/state"
            ]
        assert [state.speed for state in read] == a_recording().signals["speed"].tolist()

    def test_rerun_loads_it(self, mcap, tmp_path):
        script = (
            "import sys, rerun as rr\n"
            "rr.init('bag'); rr.save(sys.argv[2]); rr.log_file_from_path(sys.argv[1]); rr.disconnect()\n"
        )
        out = tmp_path / "bag.rrd"
        run = subprocess.run([sys.executable, "-c", script, mcap, out], capture_output=True, text=True, timeout=ENDING)
        assert run.returncode == 0, run.stderr
        assert b"/bench/state" in out.read_bytes()


class TestOutput:
    def test_an_existing_bag_is_refused(self, bag, tmp_path):
        with pytest.raises(InputError, match=r"run: holds a bag already; .*--force"):
            write_bag(a_recording(), tmp_path)
        write_bag(a_recording(50), tmp_path, force=True)
        assert len(load(bag)) == 50
        with pytest.raises(InputError, match="exists already"):
            write_mcap(a_recording(), bag / "run.mcap")
        with pytest.raises(InputError, match="exists already"):
            StreamWriter(bag)

    def test_a_place_that_cannot_be_written(self, tmp_path):
        (tmp_path / "file").touch()
        with pytest.raises(InputError, match="cannot be written"):
            write_bag(a_recording(), tmp_path / "file")
        with pytest.raises(InputError, match="cannot be written"):
            StreamWriter(tmp_path / "file" / "bag")
        with pytest.raises(InputError, match="is a folder"):
            write_mcap(a_recording(), tmp_path)

    def test_an_interrupted_write_leaves_nothing(self, tmp_path, monkeypatch):
        def interrupt(_):
            raise KeyboardInterrupt

        monkeypatch.setattr("ema_bench_replay.bags.mcap_file.McapFile.finish", interrupt)
        with pytest.raises(KeyboardInterrupt):
            write_bag(a_recording(), tmp_path)
        assert not [path for path in tmp_path.rglob("*") if path.is_file()]
        monkeypatch.undo()
        write_bag(a_recording(), tmp_path)


def test_definitions_need_no_ros(monkeypatch, tmp_path):
    """Where no ROS is installed, the checkout and the standard types suffice to write a bag."""
    message_definition.cache_clear()
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    monkeypatch.setattr("sys.prefix", "/nowhere")
    try:
        assert_same(read_bag(write_bag(a_recording(), tmp_path)), a_recording())
        with pytest.raises(InputError, match="no such message is installed"):
            message_definition("missing_msgs/msg/Missing")
    finally:
        message_definition.cache_clear()


def test_no_reader_or_writer_needs_ros():
    names = ("traces.trace_csv", "bags.bag_reader", "bags.bag_writer", "bags.stream_writer")
    modules = ", ".join(f"ema_bench_replay.{name}" for name in names)
    script = f"import sys, {modules}; assert not {{'rclpy', 'pandas'}} & set(sys.modules)"
    assert subprocess.run([sys.executable, "-c", script]).returncode == 0


def test_a_run_that_begins_a_million_turns_away_is_read_from_zero(tmp_path):
    """A bench that was never switched off: its bag is compared as the trace of the same motion is."""
    away = 2e6 * math.pi
    recording = a_recording()
    positions = {"motor_position": away, "output_position": away / 124.0}
    held = {name: values + positions.get(name, 0.0) for name, values in recording.signals.items()}
    moved = replace(recording, signals=held, motor_angle_origin=1.0 - away, output_angle_origin=2.0 - away / 124.0)
    write_mcap(moved, tmp_path / "away.mcap")
    found = load(tmp_path / "away.mcap")
    for name in positions:
        expected = recording.signals[name] - recording.signals[name][0]
        assert found.signals[name] == pytest.approx(expected, abs=1e-8), name
    first = recording.signals["motor_position"][0]
    assert found.motor_angle_origin == pytest.approx(1.0 + first, abs=1e-8)
    assert read_bag(tmp_path / "away.mcap").signals["motor_position"][0] == pytest.approx(away + first)

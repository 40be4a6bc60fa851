"""Bags: exact both ways, open to every tool, and readable whoever wrote them and however they were cut."""

import math
import os
import signal
import struct
import subprocess
import sys

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as nps
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader

from ema_bench_replay.bags.bag_metadata import STATE_QOS, qos_profile
from ema_bench_replay.bags.bag_reader import read_bag
from ema_bench_replay.bags.bag_writer import write_bag, write_mcap
from ema_bench_replay.bags.cdr import parse, serialise
from ema_bench_replay.bags.definitions import message_definition
from ema_bench_replay.bags.stream_writer import StreamWriter
from ema_bench_replay.errors import InputError
from ema_bench_replay.load import load
from ema_bench_replay.recording import NO_DATE, SIGNALS, Recording

STATE = "ema_twin_msgs/msg/EmaState"
DEFINITION = message_definition(STATE).text


def a_recording(samples=1200, name="run", **changes):
    stamps = np.arange(samples) * 2_000_000
    random = np.random.default_rng(1)
    names = ("current", "speed", "motor_position", "output_position")
    parts = {
        "stamps": stamps,
        "signals": {signal: random.normal(size=samples) for signal in names},
        "start": 1_713_350_000_123_456_789,
        "motor_angle_origin": -math.pi,
        "output_angle_origin": 1.25,
        "metadata": {"source": "run.CSV", "map_text": "a: 1\nb: ü\n"},
        "warnings": ("run.CSV: a first thing", "run.CSV: a second one"),
    }
    return Recording(name, **{**parts, **changes})


def assert_same(one, other):
    assert one.name == other.name and one.start == other.start and np.array_equal(one.stamps, other.stamps)
    assert list(one.signals) == list(other.signals)
    for name, values in one.signals.items():
        assert values.tobytes() == other.signals[name].tobytes(), name
    origins = [(r.motor_angle_origin, r.output_angle_origin) for r in (one, other)]
    assert np.array_equal(*origins, equal_nan=True)
    assert one.metadata == other.metadata and one.warnings == other.warnings


def refused(path, *words, topic=None):
    with pytest.raises(InputError) as caught:
        read_bag(path, topic=topic)
    message = str(caught.value)
    assert "\n" not in message
    for word in (str(path), "; ", *words):
        assert word in message, message


@pytest.fixture
def bag(tmp_path):
    return write_bag(a_recording(), tmp_path)


@pytest.fixture
def mcap(bag):
    return bag / "run.mcap"


class TestRoundTrip:
    def test_what_was_written_is_read(self, bag, mcap):
        assert_same(load(bag), a_recording())
        assert_same(load(mcap), a_recording())

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
    @settings(max_examples=60, deadline=None)
    def test_any_recording(self, tmp_path_factory, parts, start, origin):
        steps, signals = parts
        recording = Recording("any", np.cumsum(steps) - steps[0], signals, start, origin)
        folder = tmp_path_factory.mktemp("any")
        assert_same(load(write_bag(recording, folder)), recording)

    def test_a_trace_and_its_bag_are_the_same(self, traces, tmp_path):
        for path in traces:
            recording = load(path)
            rows = len(path.read_bytes().splitlines()) - 1
            assert len(recording) == rows
            assert_same(load(write_bag(recording, tmp_path)), recording)

    def test_without_positions_there_are_no_joints(self, tmp_path):
        recording = a_recording(signals={"current": np.zeros(1200)})
        folder = write_bag(recording, tmp_path)
        with (folder / "run.mcap").open("rb") as file:
            topics = {channel.topic for channel in make_reader(file).get_summary().channels.values()}
        assert topics == {"/bench/state"}

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
        with (folder / "run.mcap").open("rb") as file:
            chunks = make_reader(file).get_summary().chunk_indexes
        assert max(chunk.message_end_time - chunk.message_start_time for chunk in chunks) <= 10**9

    def test_metadata_yaml(self, bag):
        content = yaml.safe_load((bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
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
        run = subprocess.run([sys.executable, "-c", script, mcap, out], capture_output=True, text=True, timeout=60)
        assert run.returncode == 0, run.stderr
        assert b"/bench/state" in out.read_bytes()


def write_other(
    path, samples, *, definition=DEFINITION, compression=CompressionType.NONE, chunked=True, topic="/bench/state"
):
    """A bag as another tool may write it: one call a message, `samples` of fields and log times."""
    types, root = parse(definition, STATE)
    with path.open("wb") as stream:
        writer = Writer(stream, compression=compression, use_chunking=chunked, chunk_size=4096)
        writer.start(profile="ros2")
        schema = writer.register_schema(STATE, "ros2msg", definition.encode())
        channel = writer.register_channel(topic, "cdr", schema, {"offered_qos_profiles": ""})
        for values, log_time in samples:
            stamp = dict(zip(("sec", "nanosec"), divmod(values["stamp"], 10**9), strict=True))
            header = {"stamp": stamp, "frame_id": values.get("frame_id", "")}
            writer.add_message(channel, log_time, serialise(types, root, {**values, "header": header}), log_time)
        writer.finish()
    return path


def some_samples(count=50, **fields):
    return [
        ({"stamp": 10**9 + k * 10**6, "run": 3, "sequence": k, "current": k / 7, "speed": -k / 3, **fields}, 10**9 + k)
        for k in range(count)
    ]


class TestOtherWriters:
    @pytest.mark.parametrize("compression", list(CompressionType))
    def test_compressions(self, tmp_path, compression):
        recording = read_bag(write_other(tmp_path / "b.mcap", some_samples(), compression=compression))
        assert list(recording.signals) == ["current", "speed"] and recording.warnings == ()
        assert recording.signals["current"].tolist() == [k / 7 for k in range(50)]
        assert recording.start == 10**9 and recording.stamps[1] == 10**6

    def test_no_chunks(self, tmp_path):
        recording = read_bag(write_other(tmp_path / "b.mcap", some_samples(), chunked=False))
        assert len(recording) == 50 and recording.warnings == ()

    def test_names_of_frames_that_change(self, tmp_path):
        samples = some_samples()
        for number, (values, _) in enumerate(samples):
            values["frame_id"] = "f" * (number * 7 % 11)
        recording = read_bag(write_other(tmp_path / "b.mcap", samples))
        assert recording.signals["speed"].tolist() == [-k / 3 for k in range(50)]

    def test_another_version_of_the_type(self, tmp_path):
        definition = (
            "std_msgs/Header header\nstring<=20 note\nint8 LIMIT = 3\nfloat32[3] extra\nuint16[] list\nbool ok true\n"
            "uint64 sequence\nfloat64 speed\nfloat64 current\n" + DEFINITION[DEFINITION.index("=" * 80) :]
        )
        samples = some_samples(note="abc", extra=[1, 2, 3], list=[7], ok=True)
        recording = read_bag(write_other(tmp_path / "b.mcap", samples, definition=definition))
        assert recording.signals["current"].tolist() == [k / 7 for k in range(50)]
        assert math.isnan(recording.motor_angle_origin) and list(recording.signals) == ["current", "speed"]

    def test_big_endian(self, tmp_path):
        definition = "std_msgs/Header header\nfloat64 current\n" + DEFINITION[DEFINITION.index("=" * 80) :]
        with (tmp_path / "b.mcap").open("wb") as stream:
            writer = Writer(stream)
            writer.start(profile="ros2")
            schema = writer.register_schema(STATE, "ros2msg", definition.encode())
            channel = writer.register_channel("/bench/state", "cdr", schema, {"offered_qos_profiles": ""})
            for k in range(3):
                writer.add_message(channel, k, b"\0\0\0\0" + struct.pack(">iIIB3xd", 1, k, 1, 0, k / 7), k)
            writer.finish()
        recording = read_bag(tmp_path / "b.mcap")
        assert recording.signals["current"].tolist() == [0, 1 / 7, 2 / 7] and recording.stamps.tolist() == [0, 1, 2]

    def test_out_of_order_and_repeated(self, tmp_path):
        samples = some_samples()
        samples[10], samples[30] = (samples[10][0], samples[30][1]), (samples[30][0], samples[10][1])
        recording = read_bag(write_other(tmp_path / "b.mcap", [*samples[25:], *samples[:25], samples[7]]))
        assert recording.signals["current"].tolist() == [k / 7 for k in range(50)]
        assert recording.warnings == ("b.mcap: /bench/state: 1 samples are there twice; used once",)

    def test_samples_that_are_missing(self, tmp_path):
        recording = read_bag(write_other(tmp_path / "b.mcap", some_samples()[5:20] + some_samples()[23:]))
        assert len(recording) == 42 and recording.gaps[0].missing == 3
        late, missing = recording.warnings
        assert "begins with sample 5 of its run" in late and "3 samples are missing" in missing

    def test_the_first_of_several_runs(self, tmp_path):
        second = [({**values, "run": 4, "current": 9.0}, log_time + 1000) for values, log_time in some_samples(20)]
        recording = read_bag(write_other(tmp_path / "b.mcap", some_samples() + second))
        assert len(recording) == 50 and recording.signals["current"].max() < 9
        assert recording.warnings == ("b.mcap: /bench/state: holds 2 runs; the first one is used (50 samples)",)

    def test_runs_without_number(self, tmp_path):
        definition = "std_msgs/Header header\nfloat64 current\n" + DEFINITION[DEFINITION.index("=" * 80) :]
        again = [(values, log_time + 1000) for values, log_time in some_samples(20)]
        recording = read_bag(write_other(tmp_path / "b.mcap", some_samples() + again, definition=definition))
        assert len(recording) == 50 and "holds 2 runs" in recording.warnings[0]

    def test_topics(self, tmp_path):
        only = write_other(tmp_path / "only.mcap", some_samples(), topic="/twin/state")
        assert len(read_bag(only)) == 50
        writer = StreamWriter(tmp_path / "both")
        types, root = parse(DEFINITION, STATE)
        for number, topic in enumerate(("/twin/state", "/bench/state")):
            writer.add_topic(topic, STATE, STATE_QOS)
            for k in range(10):
                header = {"stamp": {"sec": 1, "nanosec": k}}
                values = {"header": header, "run": 1, "sequence": k, "current": number}
                writer.write(topic, serialise(types, root, values), 10**9 + k)
        assert writer.finish() == {"/twin/state": 10, "/bench/state": 10}
        assert read_bag(tmp_path / "both").signals["current"][0] == 1
        assert read_bag(tmp_path / "both", topic="/twin/state").signals["current"][0] == 0
        refused(tmp_path / "both" / "both.mcap", "/other", "/twin/state", topic="/other")

    def test_a_twin_that_does_not_know_its_torque_at_once(self, tmp_path):
        samples = some_samples()
        for values, _ in samples[1:]:
            values["unexplained_torque"] = 0.1
        recording = read_bag(write_other(tmp_path / "b.mcap", samples))
        assert not recording.has("unexplained_torque") and "unexplained_torque" in recording.warnings[0]


class TestDamage:
    @pytest.mark.parametrize("share", [0.5, 0.6, 0.7])
    def test_a_cut_file_is_used_up_to_there(self, mcap, share):
        data = mcap.read_bytes()
        mcap.write_bytes(data[: int(len(data) * share)])
        recording = load(mcap)
        assert 400 <= len(recording) < 1200 and len(recording) % 500 == 0
        whole = a_recording()
        assert recording.signals["speed"].tobytes() == whole.signals["speed"][: len(recording)].tobytes()
        assert recording.metadata == whole.metadata
        assert recording.warnings == (*whole.warnings, "run.mcap: the file is cut; used up to the last whole part")

    def test_a_file_without_its_last_bytes_is_whole_but_said(self, mcap):
        mcap.write_bytes(mcap.read_bytes()[:-5])
        recording = load(mcap)
        assert len(recording) == 1200 and "is cut" in recording.warnings[-1]

    @pytest.mark.parametrize("keep", [1, 7, 9, 500])
    def test_a_cut_file_of_nothing_is_refused(self, mcap, keep):
        mcap.write_bytes(mcap.read_bytes()[:keep])
        refused(mcap, "MCAP" if keep < 8 else "the file is cut")

    def test_a_cut_file_without_chunks(self, tmp_path):
        path = write_other(tmp_path / "b.mcap", some_samples(), chunked=False)
        path.write_bytes(path.read_bytes()[:9000])
        recording = read_bag(path)
        assert 5 < len(recording) < 50 and "is cut" in recording.warnings[0]

    @given(st.lists(st.tuples(st.integers(0, 10**6), st.integers(0, 255)), min_size=1, max_size=5), st.integers(0))
    @settings(max_examples=150, deadline=None)
    def test_whatever_is_damaged_is_told_or_refused(self, tmp_path_factory, flips, cut):
        path = tmp_path_factory.getbasetemp() / "damaged.mcap"
        write_mcap(a_recording(600), path, force=True)
        data = bytearray(path.read_bytes())
        for place, value in flips:
            data[place % len(data)] = value
        path.write_bytes(data[: max(cut % (3 * len(data)), 8)])
        try:
            recording = read_bag(path)
        except InputError as error:
            assert "\n" not in str(error)
        else:
            assert len(recording) <= 600


class TestBadInput:
    def test_many_topics_are_named_in_part(self, tmp_path):
        with (tmp_path / "b.mcap").open("wb") as stream:
            writer = Writer(stream)
            writer.start()
            for k in range(36):
                channel = writer.register_channel(f"/topic_{k:02}", "json", 0)
                writer.add_message(channel, k, b"{}", k)
            writer.finish()
        with pytest.raises(InputError, match=r"/topic_04 \(no type\) and 31 more; give a bag") as error:
            read_bag(tmp_path / "b.mcap")
        assert "/topic_05" not in str(error.value)

    def test_other_types(self, tmp_path):
        writer = StreamWriter(tmp_path / "b")
        writer.add_topic("/chatter", "std_msgs/msg/Header", qos_profile(reliability="reliable", durability="volatile"))
        writer.write("/chatter", bytes(16), 10**9)
        writer.finish()
        refused(tmp_path / "b" / "b.mcap", "/chatter (std_msgs/msg/Header)", STATE)

    def test_no_mcap(self, tmp_path):
        (tmp_path / "b.mcap").write_bytes(b"what is this?" * 100)
        refused(tmp_path / "b.mcap", "no MCAP")
        (tmp_path / "e.mcap").write_bytes(b"")
        refused(tmp_path / "e.mcap", "no MCAP")

    def test_folders(self, bag, tmp_path):
        (tmp_path / "none").mkdir()
        refused(tmp_path / "none", "no .mcap")
        (bag / "second.mcap").touch()
        refused(bag, "2 .mcap files", "second.mcap")

    def test_nan_in_places(self, tmp_path):
        samples = some_samples()
        samples[7][0]["speed"] = math.nan
        refused(write_other(tmp_path / "b.mcap", samples), "speed", "1 of 50", "0.007 s")

    def test_nothing_known(self, tmp_path):
        refused(write_other(tmp_path / "b.mcap", some_samples(current=math.nan, speed=math.nan)), "all signals are NaN")

    def test_no_messages(self, tmp_path):
        refused(write_other(tmp_path / "b.mcap", []), "no samples")

    def test_time_that_stands_still(self, tmp_path):
        samples = [({**values, "stamp": 10**9}, log_time) for values, log_time in some_samples()]
        refused(write_other(tmp_path / "b.mcap", samples), "time does not go on at sample 1")


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


class TestStreamWriter:
    def test_other_tools_read_it(self, tmp_path):
        writer = StreamWriter(tmp_path / "live")
        types, root = parse(DEFINITION, STATE)
        writer.add_topic("/bench/state", STATE, STATE_QOS)
        writer.add_topic("/twin/state", STATE, STATE_QOS + "\n" + STATE_QOS)
        for k in range(3000):
            header = {"stamp": {"sec": 1, "nanosec": 0}, "frame_id": "x"}
            data = serialise(types, root, {"header": header, "sequence": k})
            writer.write(("/bench/state", "/twin/state")[k % 2], data, NO_DATE + k * 1_000_000, sequence=k)
        assert writer.finish() == {"/bench/state": 1500, "/twin/state": 1500}
        with AnyReader([tmp_path / "live"]) as reader:
            times = [(time, reader.deserialize(data, c.msgtype).sequence) for c, time, data in reader.messages()]
        assert times == [(NO_DATE + k * 1_000_000, k) for k in range(3000)]
        with (tmp_path / "live" / "live.mcap").open("rb") as file:
            chunks = make_reader(file).get_summary().chunk_indexes
        assert len(chunks) == 6 and all(c.message_end_time - c.message_start_time < 5e8 for c in chunks)

    def test_a_topic_that_nobody_offers_yet(self, tmp_path):
        writer = StreamWriter(tmp_path / "live")
        writer.add_topic("/empty", "std_msgs/msg/Header", "")
        assert writer.finish() == {"/empty": 0}
        [topic] = yaml.safe_load((tmp_path / "live" / "metadata.yaml").read_text())["rosbag2_bagfile_information"][
            "topics_with_message_count"
        ]
        assert topic["topic_metadata"]["offered_qos_profiles"] == []
        with (tmp_path / "live" / "live.mcap").open("rb") as file:
            assert [channel.topic for channel in make_reader(file).get_summary().channels.values()] == ["/empty"]

    def test_a_killed_writer_loses_less_than_a_second(self, tmp_path):
        script = f"""
import itertools, sys, time
from ema_bench_replay.bags.bag_metadata import STATE_QOS
from ema_bench_replay.bags.cdr import parse, serialise
from ema_bench_replay.bags.definitions import message_definition
from ema_bench_replay.bags.stream_writer import StreamWriter
types, root = parse(message_definition("{STATE}").text, "{STATE}")
writer = StreamWriter(sys.argv[1])
writer.add_topic("/bench/state", "{STATE}", STATE_QOS)
begin = time.time_ns()
for k in itertools.count():
    now = time.time_ns()
    stamp = dict(zip(("sec", "nanosec"), divmod(now, 10**9)))
    writer.write("/bench/state", serialise(types, root, dict(header=dict(stamp=stamp), sequence=k, current=1.0)), now)
    if now - begin > 2e9:
        print(now, flush=True)
        time.sleep(60)
    time.sleep(1e-3)
"""
        run = subprocess.Popen([sys.executable, "-c", script, tmp_path / "live"], stdout=subprocess.PIPE, text=True)
        last = int(run.stdout.readline())
        os.kill(run.pid, signal.SIGKILL)
        run.wait()
        recording = load(tmp_path / "live")
        assert recording.warnings == ("live.mcap: the file is cut; used up to the last whole part",)
        assert last - (recording.start + recording.stamps[-1]) < 1e9


def test_definitions_need_no_ros(monkeypatch, tmp_path):
    """Where no ROS is installed, the checkout and the standard types suffice to write a bag."""
    message_definition.cache_clear()
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    monkeypatch.setattr("sys.prefix", "/nowhere")
    try:
        assert_same(load(write_bag(a_recording(), tmp_path)), a_recording())
        with pytest.raises(InputError, match="no such message is installed"):
            message_definition("missing_msgs/msg/Missing")
    finally:
        message_definition.cache_clear()


def test_no_reader_or_writer_needs_ros():
    names = ("traces.trace_csv", "bags.bag_reader", "bags.bag_writer", "bags.stream_writer")
    modules = ", ".join(f"ema_bench_replay.{name}" for name in names)
    script = f"import sys, {modules}; assert not {{'rclpy', 'pandas'}} & set(sys.modules)"
    assert subprocess.run([sys.executable, "-c", script]).returncode == 0

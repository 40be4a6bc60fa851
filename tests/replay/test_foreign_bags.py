"""Bags that other tools wrote, or that are damaged: read as far as they go, or refused in one line."""

import math
import resource
import struct

import lz4.frame
import pytest
import zstandard
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.records import Chunk, Header
from mcap.writer import CompressionType, Writer

from ema_bench_replay.bags import packed_messages
from ema_bench_replay.bags.bag_metadata import STATE_QOS, qos_profile
from ema_bench_replay.bags.bag_reader import read_bag
from ema_bench_replay.bags.bag_writer import write_mcap
from ema_bench_replay.bags.mcap_file import MAGIC, bytes_of
from ema_bench_replay.bags.stream_writer import StreamWriter
from ema_bench_replay.errors import InputError
from ema_bench_replay.load import load
from tests.bags import DEFINITION, STATE, a_recording, other_writer, refused, serialised, some_samples, write_other

OTHER_TYPES = DEFINITION[DEFINITION.index("=" * 80) :]
"""What the definition of a state adds for the types within it."""


def write_bytes(file, definition, *samples):
    """A bag of messages of any bytes, each at the nanosecond of its number."""
    with other_writer(file, definition) as (writer, channel):
        for time, content in enumerate(samples):
            writer.add_message(channel, time, content, time)


def packed(message):
    return zstandard.ZstdCompressor().compress(message)


def states(count=50):
    """Serialised states, a period of 1 ms apart."""
    return [content for content, _ in serialised(some_samples(count))]


class TestPackedMessages:
    """As ``ros2 bag record --compression-mode message --compression-format zstd`` writes them."""

    def test_are_read(self, tmp_path):
        write_bytes(tmp_path / "b.mcap", DEFINITION, *map(packed, states()))
        recording = read_bag(tmp_path / "b.mcap")
        assert recording.signals["current"].tolist() == [k / 7 for k in range(50)]
        assert recording.warnings == ()

    def test_those_that_are_damaged_or_too_large_are_refused(self, tmp_path):
        good = packed(states()[0])
        write_bytes(tmp_path / "cut.mcap", DEFINITION, good, packed(states()[1])[:-9] + b"\xff" * 20)
        refused(tmp_path / "cut.mcap", "a message")
        write_bytes(tmp_path / "large.mcap", DEFINITION, good, packed(bytes(1 << 20)))
        refused(tmp_path / "large.mcap", "unpacks to more than 64 KiB")
        bomb = zstandard.ZstdCompressor(level=19).compress(bytes(1 << 28))
        write_bytes(tmp_path / "bomb.mcap", DEFINITION, bomb)
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        refused(tmp_path / "bomb.mcap", "unpacks to more than 64 KiB")
        assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 64 << 10  # KiB

    @pytest.mark.parametrize("told", [True, False], ids=["size told", "size not told"])
    def test_one_that_is_cut_anywhere_is_refused(self, told, tmp_path):
        """Cut in its checksum too, though all that it holds is there then."""
        packer = zstandard.ZstdCompressor(write_content_size=told, write_checksum=True)
        good, frame = (packer.compress(state) for state in states(2))
        write_bytes(tmp_path / "b.mcap", DEFINITION, good, frame)
        assert len(read_bag(tmp_path / "b.mcap")) == 2
        for size in (0, 3, 5, len(frame) // 2, *range(len(frame) - 12, len(frame))):
            write_bytes(tmp_path / "b.mcap", DEFINITION, good, frame[:size])
            refused(tmp_path / "b.mcap", "a message is packed with zstd and damaged")

    def test_those_of_a_block_are_bounded_together(self, tmp_path, monkeypatch):
        monkeypatch.setattr(packed_messages, "_LARGEST_BLOCK", 1000)
        write_bytes(tmp_path / "b.mcap", DEFINITION, *map(packed, states()))
        refused(tmp_path / "b.mcap", "with those beside it")


@pytest.mark.parametrize("name", ["rig_0.db3", "rig_0.mcap.zstd", "rig_0.db3.zstd", "rig_0.mcap.lz4"])
def test_a_bag_of_another_kind_is_refused_with_what_converts_it(name, tmp_path):
    """The command is that of rosbags, which reads them all."""
    folder = tmp_path / "rig"
    folder.mkdir()
    (folder / "metadata.yaml").write_text("a: 1\n")
    (folder / name).write_bytes(b"SQLite format 3")
    command = "rosbags-convert --src "
    refused(folder, f"{name} is no plain MCAP", command)
    for path in (folder, folder / name):
        with pytest.raises(InputError, match=r"is no plain MCAP; convert it: .*rosbags-convert --src \S*rig --dst NEW"):
            load(path)


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
            f"uint64 sequence\nfloat64 speed\nfloat64 current\n{OTHER_TYPES}"
        )
        samples = some_samples(note="abc", extra=[1, 2, 3], list=[7], ok=True)
        recording = read_bag(write_other(tmp_path / "b.mcap", samples, definition=definition))
        assert recording.signals["current"].tolist() == [k / 7 for k in range(50)]
        assert math.isnan(recording.motor_angle_origin) and list(recording.signals) == ["current", "speed"]

    def test_big_endian(self, tmp_path):
        definition = f"std_msgs/Header header\nfloat64 current\n{OTHER_TYPES}"
        samples = [b"\0\0\0\0" + struct.pack(">iIIB3xd", 1, k, 1, 0, k / 7) for k in range(3)]
        write_bytes(tmp_path / "b.mcap", definition, *samples)
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
        definition = f"std_msgs/Header header\nfloat64 current\n{OTHER_TYPES}"
        again = [(values, log_time + 1000) for values, log_time in some_samples(20)]
        recording = read_bag(write_other(tmp_path / "b.mcap", some_samples() + again, definition=definition))
        assert len(recording) == 50 and "holds 2 runs" in recording.warnings[0]

    def test_topics(self, tmp_path):
        only = write_other(tmp_path / "only.mcap", some_samples(), topic="/twin/state")
        assert len(read_bag(only)) == 50
        writer = StreamWriter(tmp_path / "both")
        for number, topic in enumerate(("/twin/state", "/bench/state")):
            writer.add_topic(topic, STATE, STATE_QOS)
            for message, logged in serialised(some_samples(10, current=number)):
                writer.write(topic, message, logged)
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
        assert recording.warnings == (
            *whole.warnings,
            "run.mcap: the file is cut, so only what is before that can be used",
        )

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

    @pytest.mark.slow
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

    @pytest.mark.parametrize(
        ("samples", "told"),
        [
            ([], "no samples"),
            (some_samples(current=math.nan, speed=math.nan), "all signals are NaN"),
            (some_samples(stamp=10**9), "time does not go on at sample 1"),
        ],
    )
    def test_messages_of_which_nothing_can_be_made(self, tmp_path, samples, told):
        refused(write_other(tmp_path / "b.mcap", samples), told)


class TestBounds:
    """What a file says of its own size is no reason to believe it, nor to make room for it."""

    @pytest.mark.parametrize(("name", "compress"), [("zstd", zstandard.compress), ("lz4", lz4.frame.compress)])
    @pytest.mark.parametrize("claimed", [1000, 1 << 30, 1 << 60])
    def test_a_chunk_that_is_larger_than_it_says_or_says_too_much(self, tmp_path, name, compress, claimed):
        path = tmp_path / "b.mcap"
        bomb = Chunk(name, compress(bytes(64 << 20)), 1, 0, 0, claimed)
        path.write_bytes(MAGIC + b"".join(map(bytes_of, (Header("ros2", ""), bomb))))
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        refused(path, "chunk is damaged")
        assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 32 << 10  # kB: half of what was packed

    @pytest.mark.parametrize(
        ("lines", "told"),
        [
            ("float64 current\nfloat64 current\n", "has the field current twice"),
            ("float64[3] current\n", "several numbers as its current"),
            (f"float64 current\ntest/Loop a\n{'=' * 80}\nMSG: test/Loop\ntest/Loop a\n", "contains itself"),
            ("float64 current\n" + "# much\n" * 200_000, "more than 1 MiB"),
            (
                "float64 current\ntest/D0 a\n"
                + "".join(f"{'=' * 80}\nMSG: test/D{k}\ntest/D{k + 1} a\ntest/D{k + 1} b\n" for k in range(40))
                + f"{'=' * 80}\nMSG: test/D40\nint8[0] a\n",
                "more than 100000 fields",
            ),
        ],
    )
    def test_definitions_that_lead_nowhere(self, tmp_path, lines, told):
        path = write_other(tmp_path / "good.mcap", some_samples(3))
        write_bytes(tmp_path / "b.mcap", f"std_msgs/Header header\n{lines}{OTHER_TYPES}", b"\0\1\0\0" + bytes(200))
        assert len(read_bag(path)) == 3
        refused(tmp_path / "b.mcap", told)

    def test_a_header_without_a_stamp(self, tmp_path):
        definition = f"std_msgs/Header header\nfloat64 current\n{'=' * 80}\nMSG: std_msgs/Header\nstring frame_id\n"
        write_bytes(tmp_path / "b.mcap", definition, b"\0\1\0\0" + bytes(40))
        refused(tmp_path / "b.mcap", "header.stamp.sec")

"""Bags that are written while they run."""

import os
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from mcap.writer import CompressionType
from rosbags.highlevel import AnyReader

from ema_bench_replay.bags.bag_metadata import STATE_QOS
from ema_bench_replay.bags.recover import recover
from ema_bench_replay.bags.stream_writer import StreamWriter
from ema_bench_replay.errors import InputError
from ema_bench_replay.load import load
from ema_bench_replay.recording import NO_DATE
from tests.bags import STATE, assert_same, listed_in, serialised, some_samples, summary_of, write_other
from tests.command_line import done_here


class TestStreamWriter:
    def test_other_tools_read_it(self, tmp_path):
        writer = StreamWriter(tmp_path / "live")
        writer.add_topic("/bench/state", STATE, STATE_QOS)
        writer.add_topic("/twin/state", STATE, STATE_QOS + "\n" + STATE_QOS)
        for k, (message, _) in enumerate(serialised(some_samples(3000))):
            writer.write(("/bench/state", "/twin/state")[k % 2], message, NO_DATE + k * 1_000_000, sequence=k)
        assert writer.finish() == {"/bench/state": 1500, "/twin/state": 1500}
        with AnyReader([tmp_path / "live"]) as reader:
            times = [(time, reader.deserialize(data, c.msgtype).sequence) for c, time, data in reader.messages()]
        assert times == [(NO_DATE + k * 1_000_000, k) for k in range(3000)]
        chunks = summary_of(tmp_path / "live" / "live.mcap").chunk_indexes
        assert len(chunks) >= 30 and all(c.message_end_time - c.message_start_time < 1e8 for c in chunks)

    def test_a_topic_that_nobody_offers_yet(self, tmp_path):
        writer = StreamWriter(tmp_path / "live")
        writer.add_topic("/empty", "std_msgs/msg/Header", "")
        assert writer.finish() == {"/empty": 0}
        [topic] = listed_in(tmp_path / "live")["topics_with_message_count"]
        assert topic["topic_metadata"]["offered_qos_profiles"] == []
        channels = summary_of(tmp_path / "live" / "live.mcap").channels.values()
        assert [channel.topic for channel in channels] == ["/empty"]

    @pytest.mark.slow
    def test_a_killed_writer_loses_a_quarter_of_a_second_and_the_rest_is_recovered(self, tmp_path):
        script = f"""
import itertools, sys, time
from ema_bench_replay.bags.bag_metadata import STATE_QOS
from ema_bench_replay.bags.cdr import parse, serialise
from ema_bench_replay.bags.definitions import message_definition
from ema_bench_replay.bags.recover import recover
from ema_bench_replay.bags.stream_writer import StreamWriter
from ema_bench_replay.errors import InputError
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
        assert recording.warnings == ("live.mcap: the file is cut, so only what is before that can be used",)
        assert last - (recording.start + recording.stamps[-1]) < 0.25e9
        cut = tmp_path / "live" / "live.mcap"
        before = cut.read_bytes()
        found = recover(cut, tmp_path / "whole.mcap")
        assert cut.read_bytes() == before and found.damage == "the file is cut"
        (tmp_path / "live" / "live_recovered.mcap").write_bytes((tmp_path / "whole.mcap").read_bytes())
        assert_same(load(tmp_path / "live"), replace(recording, name="live_recovered", warnings=()))
        assert found.messages == {"/bench/state": len(recording)}
        assert_same(load(tmp_path / "whole.mcap"), replace(recording, name="whole", warnings=()))
        assert summary_of(tmp_path / "whole.mcap").statistics.message_count == len(recording)
        with AnyReader([tmp_path / "whole.mcap"]) as reader:
            assert sum(1 for _ in reader.messages()) == len(recording)


class TestRecover:
    @pytest.fixture
    def whole(self, tmp_path):
        return write_other(tmp_path / "whole.mcap", some_samples(500), compression=CompressionType.ZSTD)

    def test_a_cut_file_at_every_place(self, whole, tmp_path):
        data = whole.read_bytes()
        counts = []
        for share in (0.999, 0.9, 0.5, 0.2):
            cut = tmp_path / "cut.mcap"
            cut.write_bytes(data[: int(share * len(data))])
            counts.append(recover(cut, tmp_path / "out.mcap", force=True).messages["/bench/state"])
            assert len(load(tmp_path / "out.mcap")) == counts[-1] == len(load(cut))
        assert counts == sorted(counts, reverse=True) and counts[0] == 500 > counts[-1] > 0

    def test_what_is_torn_off_is_told(self, tmp_path):
        writer = StreamWriter(tmp_path / "live")
        writer.add_topic("/slow", "std_msgs/msg/Header", "")
        writer.add_topic("/fast", "std_msgs/msg/Header", "")
        for k in range(200):
            writer.write("/fast", b"\0\1\0\0" + bytes(13), k * 10_000_000)
            if k % 50 == 0:
                writer.write("/slow", b"\0\1\0\0" + bytes(13), k * 10_000_000)
        writer.flush()
        whole_chunks = writer.path.stat().st_size
        writer.write("/fast", b"\0\1\0\0" + bytes(13), 2_000_000_000)
        writer.flush()
        torn = writer.path.stat().st_size - whole_chunks - 70  # within the chunk itself
        cut = tmp_path / "cut.mcap"
        cut.write_bytes(writer.path.read_bytes()[: whole_chunks + torn])
        found = recover(cut, tmp_path / "out.mcap")
        assert found.torn == torn > 0
        assert found.topics == {"/fast": (200, pytest.approx(1.99)), "/slow": (4, pytest.approx(1.5))}
        cut.write_bytes(writer.path.read_bytes()[:whole_chunks])
        found = recover(cut, tmp_path / "out.mcap", force=True)
        assert (found.torn, found.damage) == (0, "the file is cut")  # between two chunks: only the index lacks
        cut.write_bytes(writer.path.read_bytes())
        assert recover(cut, tmp_path / "out.mcap", force=True).messages == {"/fast": 201, "/slow": 4}

    def test_the_command(self, whole, tmp_path, capsys):
        cut = tmp_path / "cut.mcap"
        cut.write_bytes(whole.read_bytes()[:-3000])
        done_here("recover", cut)
        told = " ".join(capsys.readouterr().out.split())
        assert f"cut_recovered.mcap: {len(load(cut))} messages over" in told and "/bench/state:" in told
        assert len(load(tmp_path / "cut_recovered.mcap")) == len(load(cut)) > 100
        for arguments, told in (
            ((cut,), "exists already"),
            ((tmp_path / "none.mcap",), "is no file"),
            ((Path(__file__), "-o", tmp_path / "x.mcap"), "is no MCAP"),
        ):
            with pytest.raises(InputError, match=told) as refused:
                done_here("recover", *arguments)
            assert "\n" not in str(refused.value)

    def test_what_is_refused(self, whole, tmp_path):
        for path, output, told in (
            (whole, whole, "the damaged bag itself"),
            (whole, tmp_path / "x.txt", "give FILE.mcap"),
            (whole, tmp_path / "there.mcap", "exists already"),
            (tmp_path / "empty.mcap", tmp_path / "x.mcap", "nothing of it can be recovered"),
        ):
            (tmp_path / "there.mcap").touch()
            (tmp_path / "empty.mcap").write_bytes(whole.read_bytes()[:40])
            with pytest.raises(InputError, match=told):
                recover(path, output)
        assert not (tmp_path / "x.mcap").exists() and len(load(whole)) == 500

    def test_a_whole_bag_stays_what_it_is(self, whole, tmp_path):
        found = recover(whole, tmp_path / "copy.mcap")
        assert found.damage is None and found.messages == {"/bench/state": 500}
        assert_same(load(tmp_path / "copy.mcap"), replace(load(whole), name="copy"))

"""Bags that are written while they run."""

import os
import signal
import subprocess
import sys

import yaml
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader

from ema_bench_replay.bags.bag_metadata import STATE_QOS
from ema_bench_replay.bags.cdr import parse, serialise
from ema_bench_replay.bags.stream_writer import StreamWriter
from ema_bench_replay.load import load
from ema_bench_replay.recording import NO_DATE
from tests.bags import DEFINITION, STATE


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

"""One topic of a bag that holds the states of several rigs becomes a recording of its own."""

import numpy as np
from mcap.writer import Writer

from ema_bench_replay.bags.cdr import parse, serialise
from ema_bench_replay.load import load
from tests.bags import DEFINITION, STATE
from tests.command_line import done, refused


def two_rigs(path):
    """A bag of 50 samples each of two rigs, whose currents and first positions differ."""
    types, root = parse(DEFINITION, STATE)
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2")
        schema = writer.register_schema(STATE, "ros2msg", DEFINITION.encode())
        rigs = {
            rig: writer.register_channel(f"/rig{rig}/bench/state", "cdr", schema, {"offered_qos_profiles": ""})
            for rig in (1, 7)
        }
        for k in range(50):
            for rig, channel in rigs.items():
                named = {"header": {"stamp": {"sec": 1, "nanosec": 2_000_000 * k}}, "sequence": k}
                values = {"current": rig + k / 7.0, "motor_position": 100.0 * rig + k}
                writer.add_message(channel, k, serialise(types, root, {**named, **values}), k)
        writer.finish()
    return path


def test_a_topic_is_taken_and_the_others_stay(tmp_path):
    bag = two_rigs(tmp_path / "rigs.mcap")
    assert "take one topic: ema-twin import" in refused("info", bag, naming=("/rig1/bench/state", "--topic"))
    for rig in (1, 7):
        done("import", bag, "--topic", f"/rig{rig}/bench/state", "-o", tmp_path / "made")
        recording = load(tmp_path / "made" / f"rigs_rig{rig}_bench_state")
        assert np.array_equal(recording.signals["current"], rig + np.arange(50) / 7.0)
        assert recording.signals["motor_position"][0] == 0.0


def test_what_holds_no_such_topic_is_refused(tmp_path):
    bag = two_rigs(tmp_path / "rigs.mcap")
    made = tmp_path / "made"
    refused("import", bag, "--topic", "/rig9/state", "-o", made, naming=("/rig9/state", "/rig7/bench/state"))
    trace = tmp_path / "trace.CSV"
    trace.write_text("a;b\n")
    refused("import", trace, "--topic", "/rig1/bench/state", "-o", made, naming=("trace.CSV", "--topic"))
    refused("import", bag, "-o", made, naming=("rigs.mcap", "already a recording"))

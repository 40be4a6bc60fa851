"""The recording itself: frozen, checked, and cut."""

import math
import os
import pickle
import threading
from pathlib import Path

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_bench_replay.outputs import new_file
from ema_bench_replay.recording import NO_DATE, SIGNALS, Recording


def a_recording(**changes):
    stamps = np.array([0, 2, 4, 10, 12]) * 1_000_000
    return Recording(**{"name": "run", "stamps": stamps, "signals": {"speed": np.arange(5.0)}, **changes})


def test_what_it_tells():
    recording = a_recording()
    assert len(recording) == 5 and recording.start == NO_DATE
    assert recording.duration == 0.012 and recording.sample_period == 0.002
    assert recording.time.tolist() == [0.0, 0.002, 0.004, 0.01, 0.012]
    [gap] = recording.gaps
    assert (gap.time, gap.missing) == (0.004, 2) and gap.duration == pytest.approx(0.006)
    assert recording.has("speed") and not recording.has("speed", "current")


def test_signals_stand_in_the_order_of_the_message():
    signals = {name: np.zeros(5) for name in reversed(SIGNALS)}
    assert tuple(a_recording(signals=signals).signals) == SIGNALS


def test_nothing_in_it_can_be_changed():
    recording = a_recording(metadata={"a": "b"})
    with pytest.raises(AttributeError):
        recording.name = "other"
    with pytest.raises(TypeError):
        recording.signals["current"] = np.zeros(5)
    with pytest.raises(TypeError):
        recording.metadata["a"] = "c"
    for array in (recording.stamps, recording.time, recording.signals["speed"]):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1


@pytest.mark.parametrize(
    "wrong",
    [
        {"stamps": np.array([0, 2, 2, 4, 6])},
        {"stamps": np.array([1, 2, 3, 4, 5])},
        {"stamps": np.array([], np.int64)},
        {"signals": {"speed": np.zeros(4)}},
        {"signals": {"velocity": np.zeros(5)}},
    ],
)
def test_parts_that_do_not_fit_are_refused(wrong):
    with pytest.raises(ValueError, match="run: "):
        a_recording(**wrong)


def test_it_goes_to_another_process():
    recording = a_recording(metadata={"a": "b"}, warnings=("w",), motor_angle_origin=1.0)
    other = pickle.loads(pickle.dumps(recording))
    assert np.array_equal(other.signals["speed"], recording.signals["speed"]) and other.metadata == recording.metadata
    assert other.warnings == ("w",) and other.motor_angle_origin == 1.0 and math.isnan(other.output_angle_origin)


def test_a_cut_keeps_command_and_position_on_one_zero():
    position = np.array([0.0, 1.0, 3.0, 6.0, 10.0])
    recording = a_recording(
        signals={"output_position": position, "output_command": position + 0.5, "motor_position": 124 * position},
        output_angle_origin=2.0,
    )
    part = recording.between(0.002, 0.010)
    assert part.signals["output_position"].tolist() == [0.0, 2.0, 5.0]
    assert part.signals["output_command"].tolist() == [0.5, 2.5, 5.5]
    assert part.output_angle_origin == 3.0 and part.stamps.tolist() == [0, 2_000_000, 8_000_000]
    assert recording.between() is recording and recording.between(0.0, 9.0) is recording


def test_a_cut_whose_first_position_is_unknown_begins_with_the_next():
    recording = a_recording(signals={"motor_position": np.array([0.0, np.nan, 3.0, 6.0, 10.0])}, motor_angle_origin=1.0)
    part = recording.between(0.002)
    assert np.array_equal(part.signals["motor_position"], [np.nan, 0.0, 3.0, 7.0], equal_nan=True)
    assert part.motor_angle_origin == 4.0


def test_cuts_that_hold_nothing_are_refused():
    for start, end in ((math.nan, None), (None, math.inf), (None, -math.inf), (1e300, None), (None, -1e300), (0.01, 0)):
        with pytest.raises(InputError, match=r"run: .* it lasts from 0 s to 0\.012 s"):
            a_recording().between(start, end)
    assert len(a_recording().between(-1e300, 1e300)) == 5


def test_an_output_is_written_through_a_link(tmp_path):
    (tmp_path / "there").mkdir()
    target, link = tmp_path / "there" / "target", tmp_path / "link"
    target.write_text("old")
    link.symlink_to(target)
    with pytest.raises(InputError, match="exists already"), new_file(link):
        pass
    with new_file(link, force=True) as file:
        file.write(b"new")
    assert link.is_symlink() and target.read_text() == "new" and list(target.parent.iterdir()) == [target]


def test_a_pipe_and_a_device_are_written_to_and_stay(tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    read = []
    reader = threading.Thread(target=lambda: read.append(pipe.read_bytes()), daemon=True)
    reader.start()
    with new_file(pipe) as file:
        file.write(b"through")
    reader.join(10)
    assert read == [b"through"] and pipe.is_fifo()
    device = tmp_path / "device"
    device.symlink_to("/dev/null")
    with new_file(device, force=True) as file:
        file.write(b"gone")
    assert device.is_symlink() and Path("/dev/null").is_char_device()


def test_a_failed_write_leaves_what_was_there(tmp_path):
    path = tmp_path / "file"
    path.write_text("old")
    with pytest.raises(RuntimeError), new_file(path, force=True) as file:
        file.write(b"half")
        raise RuntimeError
    assert path.read_text() == "old" and list(tmp_path.iterdir()) == [path]
    with pytest.raises(InputError, match="cannot be written"), new_file(tmp_path / ("x" * 300)):
        pass

"""A gear ratio that stays right where a load that goes with the angle chooses the flank of the play."""

import numpy as np
import pytest

from ema_bench_replay.recording import Recording
from ema_twin_sim.measured.ratio_of_positions import ratio_of_positions
from ema_twin_sim.measured.ratio_of_recordings import flanks_apart, ratio_of_recordings
from ema_twin_sim.new_machine.shaft import whole_ratio
from tests.play import behind_play

PERIOD = 1e-3
TIME = np.arange(12000) * PERIOD
PLAY = 1.6e-3  # rad at the output
STANDS_AT = 0.25  # rad, where the load's torque changes sign


def swung(ratio, *, amplitude=0.9, late=6, play=PLAY, wound=0.0, frequency=0.25):
    """An output that its weight holds on one flank on either side of an angle, read late; wound up by the weight."""
    ramp = np.minimum(TIME, 1.0)
    motor = ratio * amplitude * np.sin(2.0 * np.pi * frequency * TIME) * ramp**2 * (3.0 - 2.0 * ramp)
    load = np.sin(motor / ratio - STANDS_AT)
    output = motor / ratio - 0.5 * play * np.tanh(load / 0.01) - wound * load
    read = np.r_[np.full(late, output[0]), output[: len(output) - late]]
    noise = np.random.default_rng(1).normal(0.0, 1e-5, len(read))
    signals = {"motor_position": np.rint(motor * 652.0) / 652.0, "output_position": read + noise}
    return Recording("swung", np.rint(TIME * 1e9).astype(np.int64), signals)


@pytest.mark.parametrize("ratio", [50.0, -50.0, 25.9375])
def test_play_that_a_load_crosses_is_no_part_of_the_ratio(ratio):
    recording = swung(ratio)
    near = ratio_of_positions(recording)
    assert abs(near / ratio - 1.0) > 5e-4  # the slope over the whole way takes the play for a part of it
    found = ratio_of_recordings([recording], near)
    assert found.value == pytest.approx(ratio, rel=5e-5)
    assert abs(found.value - ratio) < found.uncertainty


def test_the_whole_number_is_taken_where_a_load_winds_the_gear_up():
    """The wind-up goes with the angle as the ratio does: no regression parts them, so it belongs to the doubt."""
    recordings = [swung(50.0, wound=4e-4, frequency=f) for f in (0.25, 0.4)]
    found = ratio_of_recordings(recordings, ratio_of_positions(recordings[0]))
    assert 0.01 < found.value - 50.0 < found.uncertainty
    assert whole_ratio(found.value, recordings[0], found.uncertainty) == 50.0


def test_a_ratio_that_is_not_whole_stays_one():
    recording = swung(50.4)
    found = ratio_of_recordings([recording], ratio_of_positions(recording))
    assert whole_ratio(found.value, recording, found.uncertainty) is None


def test_recordings_decide_together():
    """One that hardly moves is not asked alone: the others tell the ratio for it."""
    short = swung(50.0, amplitude=0.02, frequency=1.0)
    long = swung(50.0)
    near = ratio_of_positions(short)
    found = ratio_of_recordings([short, long], ratio_of_positions(long))
    assert abs(found.value - 50.0) < 0.2 * abs(near - 50.0)
    assert found.uncertainty < 0.1


def test_points_and_lone_positions_tell_no_other_ratio():
    recording = swung(50.0)
    assert ratio_of_recordings([], 7.0).value == 7.0
    lone = Recording("lone", recording.stamps, {"motor_position": recording.signals["motor_position"]})
    assert ratio_of_recordings([lone], 7.0).value == 7.0


def test_flanks_are_as_far_apart_whatever_chooses_them():
    """A weight that changes the flank on its way, or friction that does so at each reversal."""
    assert flanks_apart([swung(50.0)], 50.0) == pytest.approx(PLAY, rel=0.01)
    angle = 0.9 * np.sin(1.6 * TIME)
    signals = {"motor_position": 50.0 * angle, "output_position": behind_play(angle, PLAY)}
    held = Recording("held", np.rint(TIME * 1e9).astype(np.int64), signals)
    assert flanks_apart([held], 50.0) == pytest.approx(PLAY, rel=0.01)


def test_without_play_there_are_no_flanks():
    assert flanks_apart([swung(50.0, play=0.0)], 50.0) is None
    assert flanks_apart([swung(50.0, play=0.0, wound=1e-3)], 50.0) is None
    assert flanks_apart([], 50.0) is None

"""Single samples that stand alone are unknown in the motion, and said; what a machine does is not taken for them."""

import numpy as np
import pytest

from ema_twin_sim.measured.spoilt_samples import without_spoilt_motion
from tests.recorded import sampled

TIME = 0.02 * np.arange(1500)
NOISE = np.random.default_rng(8).standard_normal(len(TIME))


def moved(speed, position=None, time=TIME):
    """A recording of a speed (n,) and the way by it, or else this ``position`` (n,)."""
    position = np.cumsum(speed) * 0.02 if position is None else position
    return sampled("run", time, {"speed": speed, "motor_position": position})


def a_run():
    return 100.0 + 20.0 * np.sin(0.5 * TIME) + 0.2 * NOISE


def test_dropouts_of_the_speed_are_unknown_and_told_with_their_times():
    speed = a_run()
    position = np.cumsum(speed) * 0.02
    places = [200, 640, 641 + 60]
    speed[places] = 0.0
    found = without_spoilt_motion(moved(speed, position))
    assert np.flatnonzero(np.isnan(found.signals["speed"])).tolist() == places
    assert np.array_equal(found.signals["motor_position"], position)
    (warning,) = found.warnings
    assert "run: 3 single samples of speed" in warning and "4.000, 12.800, 14.020 s" in warning


@pytest.mark.parametrize(
    "speed",
    [
        a_run(),
        30.0 * np.sign(np.sin(0.5 * TIME)) + 0.2 * NOISE,  # steps
        np.round(a_run() / 0.5) * 0.5,  # in steps of a counter
        np.round(0.02 * a_run()),  # a count now and then
        np.where(np.arange(len(TIME)) % 97 == 0, 0.5, 0.0),
        np.where(np.arange(len(TIME)) % 400 < 3, 60.0, 100.0) + 0.2 * NOISE,  # impacts of three samples
    ],
)
def test_what_a_machine_does_is_kept(speed):
    recording = moved(speed)
    assert without_spoilt_motion(recording) is recording


def test_a_sample_that_was_taken_late_is_kept():
    """Where it is fast the position is off by a part of what it goes on in a sample."""
    recording = moved(np.where(TIME < 28.0, 1.0, 300.0) + 0.02 * NOISE)
    position = recording.signals["motor_position"].copy()
    position[1450] += 0.4 * (position[1451] - position[1450])
    late = moved(recording.signals["speed"], position)
    assert without_spoilt_motion(late) is late


@pytest.mark.parametrize("rest", [0, 10_000])
def test_a_slip_that_the_position_shows_is_kept_however_long_the_machine_rests(rest):
    speed = np.zeros(1500 + rest)
    speed[5:1500:60] = 5.0
    position = 0.02 * np.cumsum(speed)
    time = 0.02 * np.arange(len(speed))
    noisy = speed + 0.01 * np.random.default_rng(2).standard_normal(len(speed))
    shown = moved(noisy, position, time)
    assert without_spoilt_motion(shown) is shown
    if rest:
        still = moved(noisy, 0.0 * position, time)
        assert np.isnan(without_spoilt_motion(still).signals["speed"]).sum() == 25


def test_what_happens_often_is_no_error():
    speed = a_run()
    speed[::40] = 0.0
    alone = sampled("run", TIME, {"speed": speed})
    assert without_spoilt_motion(alone) is alone


def test_missing_samples_between_are_no_errors():
    speed = a_run()
    speed[::5] = np.nan
    speed[777] = -500.0
    found = without_spoilt_motion(moved(speed))
    assert np.isnan(found.signals["speed"][777]) and "1 single sample of speed" in found.warnings[0]

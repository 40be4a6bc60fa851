"""A shift between setpoint and motion: told by whichever encoders there are, and not where it is an encoder's own."""

import numpy as np
import pytest

from ema_twin_sim.comparison.setpoint_shift import ShiftSums, setpoint_shift

TIME = np.arange(0.0, 4.0, 1e-3)
SPEED = 20.0 * np.cos(3.0 * TIME)  # rad/s, of the motor
RATIO = 10.0
SHIFT = 6.8e-4  # s


def sums(motor=SHIFT, output=SHIFT):
    return {
        "motor_position": ShiftSums.of(motor * SPEED, SPEED, 1.0),
        "output_position": ShiftSums.of(output * SPEED / RATIO, SPEED, RATIO),
    }


def told(given, source="setpoint"):
    return setpoint_shift([given, given], 1e-3, RATIO, source)


def test_both_encoders_show_it():
    found = told(sums())
    assert found.seconds == pytest.approx(SHIFT) and found.samples == pytest.approx(0.68) and found.by_both


def test_one_encoder_is_enough_where_there_is_no_other():
    alone = {"motor_position": sums(motor=-SHIFT)["motor_position"]}
    assert told(alone).seconds == pytest.approx(-SHIFT) and not told(alone).by_both


@pytest.mark.parametrize("given", [sums(motor=0.0), {}])
def test_it_is_not_told_of_a_late_encoder_nor_without_a_position(given):
    assert told(given) is None


def test_it_is_not_told_where_something_else_is_most_of_the_error_or_the_current_drives():
    residual = SHIFT * SPEED + 0.03 * np.sin(7.0 * TIME)
    assert told({"motor_position": ShiftSums.of(residual, SPEED, 1.0)}) is None
    assert told(sums(), "current") is None


def test_a_twin_that_runs_away_is_not_said_to_be_late():
    assert told(sums(motor=0.119, output=0.119)) is None


def test_samples_that_are_not_known_do_not_count():
    residual = np.where(TIME < 1.0, np.nan, SHIFT * SPEED)
    assert told({"motor_position": ShiftSums.of(residual, SPEED, 1.0)}).seconds == pytest.approx(SHIFT)

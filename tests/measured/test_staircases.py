"""Commands that go in steps: a staircase has no noise, and its steps are no resolution of a sensor."""

import numpy as np
import pytest

from ema_twin_sim.measured.row_noise import rounding_noise
from ema_twin_sim.reading_noise import is_staircase, polled_noise

LEVELS = np.array([0.0, 3.0, 0.0, 6.0, 0.0, 9.0, 0.0, 12.0, 0.0])
RANDOM = np.random.default_rng(5)


def held(levels, samples=500):
    return np.repeat(np.asarray(levels, float), samples)


STAIRCASES = {
    "steps from rest": held(LEVELS),
    "levels that rise evenly": held([1, 2, 3, 4, 5]),
    "a single step": held([12.0, 0.0]),
    "two levels, many times": np.repeat(np.tile([-5.0, 5.0], 40), RANDOM.integers(30, 200, 80)),
}
READINGS = {
    "polled": np.repeat(np.sin(0.01 * np.arange(400)) + 0.01 * RANDOM.standard_normal(400), 25),
    "polled, and nothing but noise": np.repeat(0.01 * RANDOM.standard_normal(400), 25),
    "dithering between two values": 0.01 * np.rint(100.0 * (0.3045 + 0.0003 * RANDOM.standard_normal(4000))),
    "a flicker now and then": np.where(np.arange(4000) % 400 < 2, 0.31, 0.30),
    "a coarse sine": 0.1 * np.rint(10.0 * np.sin(0.02 * np.arange(4000))),
    "white": RANDOM.standard_normal(4000),
    "never changing": np.ones(4000),
}


@pytest.mark.parametrize("values", STAIRCASES.values(), ids=STAIRCASES)
def test_a_staircase_has_no_noise_and_its_steps_are_no_rounding(motor, values):
    """A logged command of 3 to 12 V had a noise as large as the whole signal, which hid what was missing."""
    assert is_staircase(values)
    assert polled_noise(values) == 0.0
    assert rounding_noise(values, motor) == 0.0


@pytest.mark.parametrize("values", READINGS.values(), ids=READINGS)
def test_readings_of_a_sensor_are_no_staircase(values):
    assert not is_staircase(values)


def test_a_staircase_that_a_sensor_reads_has_the_sensors_noise():
    read = held(LEVELS) + 0.02 * np.random.default_rng(3).standard_normal(500 * len(LEVELS))
    assert polled_noise(read) == pytest.approx(0.02, rel=0.1)


def test_the_step_of_a_coarse_reading_stays_its_rounding(motor):
    coarse = READINGS["a flicker now and then"]
    assert rounding_noise(coarse, motor) == pytest.approx(0.01 / np.sqrt(12.0))

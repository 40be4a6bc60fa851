"""The steps of an encoder: of a steady motion they are no counts, and all recordings must agree with them."""

import numpy as np
import pytest

from ema_twin_sim.new_machine.steps import common_step, smallest_step

PERIOD = 15e-3
FINE = 4e-4  # deg, what the encoder really counts


def steady_run(speed, samples=300):
    """An angle (n,) in deg that speeds up, turns steadily but for the control's ripple, and then rests."""
    rng = np.random.default_rng(7)
    speeds = speed * np.minimum(1.0, np.arange(samples) / 6.0) * (np.arange(samples) < 0.6 * samples)
    way = np.cumsum(speeds * PERIOD * (1.0 + 0.008 * rng.standard_normal(samples)))
    return FINE * np.rint((way + FINE * rng.standard_normal(samples)) / FINE)


def counted(speed, step, samples=2000):
    """A steady angle (n,) as a coarse counter shows it."""
    return step * np.floor(speed * PERIOD * np.arange(samples) / step)


def test_a_steady_motion_that_then_rests_is_no_counter():
    """At 80 deg/s, sampled every 15 ms, steps of 1.2 deg were taken for an encoder of 301 counts a turn."""
    assert smallest_step(steady_run(80.0)) is None


@pytest.mark.parametrize("share", [0.1, 0.4, 0.7, 0.9, 1.5])
def test_a_coarse_counter_is_known_at_a_steady_speed(share):
    step = 0.36
    assert smallest_step(counted(share * step / PERIOD, step)) == pytest.approx(step)


def test_the_counts_are_those_of_all_recordings():
    step = 0.36
    slow, fast = counted(0.4 * step / PERIOD, step), 2.0 * counted(0.7 * step / PERIOD, step)
    assert common_step([fast, slow]) == pytest.approx(step)  # the fast one alone shows pairs of counts only
    assert common_step([slow, np.zeros(50)]) == pytest.approx(step)
    finer = FINE * np.cumsum(np.random.default_rng(2).standard_normal(500))
    assert common_step([slow, finer]) is None
    assert common_step([]) is None


def test_init_states_no_counts_of_one_steady_recording(drafted):
    runs = [
        {"time [s]": PERIOD * np.arange(300), "q [deg]": steady_run(speed), "torque [N m]": np.linspace(0.0, 5.0, 300)}
        for speed in (80.0, 5.0)
    ]
    assert "encoder" not in drafted(*runs).said.partition("Known:")[2].partition("Estimated")[0]

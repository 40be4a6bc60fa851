"""The acceleration is smoothed as widely as its noise allows: an inertia beside a load at an angle is not too small."""

import numpy as np
import pytest

from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.measured.adaptive_acceleration import adaptive_acceleration
from ema_twin_sim.measured.observe import observe
from ema_twin_sim.measured.smoothed_motion import differentiator, smoothed_motion
from tests.open_motor import open_motor
from tests.recorded import record, sampled

PERIOD, WIDTH, NOISE = 1e-3, 5e-3, 0.05  # s, s, rad/s
TIME = np.arange(8000) * PERIOD


@pytest.fixture(scope="module")
def motor():
    return open_motor(0.05, 0.01, PERIOD).with_value("sensors.speed_noise", NOISE)


def of(speed, motor):
    """(rows, usual acceleration there, adaptive one, noise of the usual one) of a speed (n,) read with noise."""
    signals = {
        "current": np.zeros(len(speed)),
        "speed": speed + NOISE * np.random.default_rng(1).standard_normal(len(speed)),
        "motor_position": np.cumsum(speed) * PERIOD,
    }
    rows = np.arange(50, len(speed) - 50, 10)
    motion, noise = smoothed_motion(signals, TIME, PERIOD, WIDTH, motor, 0.0, True)
    usual = motion[rows, 3]
    corners = np.zeros(len(speed), bool)
    return rows, usual, adaptive_acceleration(usual, rows, noise, WIDTH, of_width(signals, motor), corners), noise


def of_width(signals, motor):
    return lambda width: differentiator(signals, PERIOD, width, motor, 0.0)


def test_a_slow_motion_loses_nearly_all_its_noise_and_nothing_else(motor):
    rows, usual, adaptive, noise = of(6.0 * np.sin(1.5 * TIME), motor)
    true = 9.0 * np.cos(1.5 * TIME)[rows]
    assert np.std(usual - true) == pytest.approx(noise, rel=0.1)
    inner = (rows > 500) & (rows < len(TIME) - 500)
    assert np.sqrt(np.mean((adaptive - true)[inner] ** 2)) < 0.1 * noise


def test_a_jump_of_the_acceleration_stays_as_sharp(motor):
    speed = np.where(TIME < 4.0, 0.0, 20.0 * (TIME - 4.0))
    rows, usual, adaptive, noise = of(speed, motor)
    near = np.abs(TIME[rows] - 4.0) < 4.0 * WIDTH
    assert 5.0 * noise < 20.0
    assert np.abs(adaptive - usual)[near].max() < 4.0 * noise


def test_rows_that_wide_kernels_do_not_reach_keep_narrower_ones(motor):
    _, usual, adaptive, _ = of(6.0 * np.sin(1.5 * TIME), motor)
    np.testing.assert_array_equal(adaptive[[0, 1, -1]], usual[[0, 1, -1]])  # 50 and 60 samples from the ends
    assert np.mean(adaptive != usual) > 0.9


def test_an_inertia_beside_a_load_at_the_position_is_not_too_small(motor):
    """A load that follows the position explains most of a sine's acceleration: noise was most of what it left."""
    speed = 6.0 * np.sin(1.5 * TIME) + 0.4 * np.sin(7.0 * TIME)
    rows, usual, adaptive, _ = of(speed, motor)
    position = np.cumsum(speed)[rows] * PERIOD
    true = np.gradient(speed, PERIOD)[rows]
    torque = 2e-5 * true + 3e-4 * position
    found = [
        np.linalg.lstsq(np.stack([a, position, np.ones(len(a))], 1), torque, rcond=None)[0][0]
        for a in (usual, adaptive)
    ]
    assert found[0] < 0.9 * 2e-5
    assert found[1] == pytest.approx(2e-5, rel=0.02)


def test_corners_where_a_machine_stands_are_not_smoothed(motor):
    speed = np.where(np.abs(TIME - 4.0) < 0.02, 0.0, 5.0)
    signals = {"current": np.zeros(len(TIME)), "speed": speed, "motor_position": np.cumsum(speed) * PERIOD}
    rows = np.arange(200, len(TIME) - 200, 10)
    usual = np.zeros(len(rows))
    stays = adaptive_acceleration(usual, rows, 1e6, WIDTH, of_width(signals, motor), speed == 0.0) == usual
    near = np.abs(TIME[rows] - 4.0)
    assert stays[near < 5.0 * WIDTH].all() and not stays[(near > 20.0 * WIDTH) & (near < 30.0 * WIDTH)].any()


def test_no_wide_kernel_covers_a_gap(motor):
    """What is interpolated there has no noise, and no motion of its own."""
    time = np.delete(TIME, slice(3000, 3400))
    speed = 30.0 + 6.0 * np.sin(1.5 * time)
    signals = {
        "current": np.sin(1.5 * time),
        "speed": speed + NOISE * np.random.default_rng(1).standard_normal(len(time)),
        "motor_position": 30.0 * time - 4.0 * np.cos(1.5 * time),
    }
    o = observe(sampled("gap", time, signals), motor)
    half = len(o.kernel) // 2
    distance = np.where(o.rows < 3000, 3000 - o.rows, o.rows - 3400)
    assert (distance > 0).all()
    assert (o.acceleration_rest[distance < 1.4 * half] == 0.0).all()
    assert (o.acceleration_rest[distance > 20 * half] != 0.0).mean() > 0.9


@pytest.mark.slow
def test_a_weight_is_right_beside_an_open_inertia_in_one_slow_sine(stock):
    hidden = stock.with_effect("gravity_load", {"torque": 0.1, "angle": 0.4}).with_value("sensors.speed_noise", 0.5)
    recordings = record(hidden, ("sine:0.1:0.25",) * 3, seconds=12.0)
    open_model = stock.with_value("sensors.speed_noise", 0.5)
    found = discover(recordings, open_model)
    assert found.added == ("gravity_load",)
    assert found.parameters["gravity_load"]["torque"]["value"] == pytest.approx(0.1, rel=0.05)

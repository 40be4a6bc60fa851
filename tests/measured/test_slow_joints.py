"""Joints that are told at the joint, slow and with samples missing: what is judged of them, and by which scale."""

import math
from dataclasses import replace

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording
from ema_twin_sim.measured.balance_estimate import estimate_balance
from ema_twin_sim.measured.observe import observe, observe_all
from ema_twin_sim.measured.scales import begun_near, rms_torque, standstill
from tests.large_arm import COULOMB, INERTIA, VISCOUS, open_arm


def swing(model, *, peak=0.5, rate=1.0, seed=2):
    """A joint without weight that swings about one angle."""
    random = np.random.default_rng(seed)
    time = np.arange(20_000) * 2e-3
    angle, speed, acceleration = (peak / rate * rate**k * np.sin(rate * time + k * math.pi / 2) for k in range(3))
    torque = INERTIA * acceleration + VISCOUS * speed + COULOMB * np.sign(speed)
    current = (torque + 0.5 * random.standard_normal(len(time))) / model.value("machine.torque_constant")
    signals = {"current": current, "speed": speed, "motor_position": angle}
    stamps = np.arange(len(time)) * 2_000_000
    return Recording("swing", stamps, signals, motor_angle_origin=0.0, output_angle_origin=0.0)


@pytest.fixture
def arm():
    return replace(open_arm(), effects={}).with_effect("coulomb_friction", {"torque": 1.0, "static_ratio": 1.0})


def test_an_inertia_shows_where_acceleration_goes_with_the_angle(arm):
    """A pure swing: any load along the angle does what the inertia does, and the scale is told all the same."""
    recordings = [swing(arm)]
    found = estimate_balance(recordings, arm, rms_torque(recordings, arm))
    assert found is not None
    assert found.inertia == pytest.approx(INERTIA, rel=0.3)
    assert found.coulomb == pytest.approx(COULOMB, rel=0.3)


@pytest.mark.parametrize("guess", [1e-4, 1e4])
def test_an_inertia_that_does_not_show_is_not_the_guess_of_the_model(guess, arm):
    """At steady speed to and fro the inertia acts at the reversals alone: it is set to what could hide there."""
    time = np.arange(20_000) * 2e-3
    rise = np.arcsin(np.sin(time)) * 2.0 / math.pi
    speed = 0.3 * np.sign(np.cos(time))
    torque = COULOMB * np.sign(speed) + VISCOUS * speed
    noise = np.random.default_rng(5).standard_normal(len(time))
    signals = {
        "current": (torque + 3.0 * noise) / arm.value("machine.torque_constant"),
        "motor_position": 0.3 * rise * math.pi / 2.0,
        "speed": speed,
    }
    run = Recording("to_and_fro", np.arange(len(time)) * 2_000_000, signals, motor_angle_origin=0.0)
    begun = begun_near([run], replace(arm, constants={**arm.constants, **_guessed(arm, guess)}))
    assert 1e-3 < begun.value("machine.motor_inertia") < 10.0


def _guessed(model, inertia):
    held = model.constants["machine.motor_inertia"]
    return {"machine.motor_inertia": replace(held, value=inertia, tolerance=math.inf)}


def test_standstill_is_at_most_a_tenth_of_the_fastest_motion(arm):
    """Of a machine of which nobody knows the inertia; however slowly it is moved, most of its motion is judged."""
    for peak in (0.5, 0.05):
        assert standstill([swing(arm, peak=peak)], arm, "current") <= 0.1 * peak


def run(speed, period, kept=slice(None)):
    """A motor without gearbox at these speeds (n,) [rad/s], a sample every ``period`` [s]; those ``kept``."""
    current = 1.0 + 0.01 * np.random.default_rng(1).standard_normal(len(speed))
    signals = {"current": current, "speed": speed, "motor_position": np.cumsum(speed) * period}
    stamps = np.arange(len(speed)) * round(1e9 * period)
    signals = {name: values[kept] for name, values in signals.items()}
    return Recording("run", stamps[kept], signals, motor_angle_origin=0.0, output_angle_origin=0.0)


def test_a_sample_that_is_missing_costs_no_rows_where_the_kernel_is_far_longer(stock):
    model = stock.with_value("machine.output_inertia", 0.0).with_value("sensors.speed_noise", 0.2)  # long kernel
    speed = 50.0 * np.cos(np.arange(20_000) * 2.5e-3)
    kept = np.arange(len(speed)) % 100 != 50
    whole, holed = observe(run(speed, 5e-4), model), observe(run(speed, 5e-4, kept), model)
    assert len(holed.rows) > 0.95 * len(whole.rows) > 100
    slow = np.arange(len(speed)) % 100 < 50  # half of the kernel and more
    assert len(observe(run(speed, 5e-4, slow), model).rows) < 0.7 * len(whole.rows)


def test_a_row_that_mostly_stands_is_not_judged_and_a_quick_reversal_is(stock):
    """Stick and slip: where a kernel sees standstill for its greater part, friction has no direction."""
    model = stock.with_value("machine.output_inertia", 0.0)
    creep = np.where(np.arange(10_000) % 25 == 0, 1.0, 0.0)
    assert len(observe(run(creep, 2e-3), model).rows) == 0
    quick = 20.0 * np.sin(np.arange(10_000) * 2e-2)
    rows = observe(run(quick, 2e-3), model).rows
    assert np.diff(rows).max() == np.diff(rows).min()


def test_a_log_without_an_even_clock_is_judged_nearly_as_well_as_one_with_it(stock):
    """A computer logs when it comes to it: a quarter of its steps is longer than one and a half usual ones."""
    model = stock.with_value("machine.output_inertia", 0.0)
    speed = 50.0 * np.cos(np.arange(40_000) * 2e-3)
    even = np.arange(0, len(speed), 4)
    steps = np.random.default_rng(3).choice([2, 3, 4, 4, 5, 7, 8, 9], len(even))
    logged = np.cumsum(steps) - steps[0]
    logged = logged[logged < len(speed)]
    whole, uneven = (observe(run(speed, 1e-3, kept), model, bridging=True) for kept in (even, logged))
    assert (
        len(uneven.rows) * len(uneven.kernel) * uneven.period > 0.8 * len(whole.rows) * len(whole.kernel) * whole.period
    )


def test_a_refusal_tells_of_an_uneven_rate_of_samples(stock):
    model = stock.with_value("machine.output_inertia", 0.0)
    steps = np.random.default_rng(3).choice([2, 3, 4, 4, 5, 7, 8, 9], 120)
    logged = np.cumsum(steps) - steps[0]
    recording = run(50.0 * np.cos(np.arange(logged[-1] + 1) * 2e-3), 1e-3, logged)
    with pytest.raises(
        InputError, match=r"or log at an even rate: run's samples come 4 ms apart, and often 8 ms or more"
    ):
        observe_all([recording], model)

"""Response of the unexplained torque to the error of one sample, from which its noise floor follows."""

import numpy as np
import pytest

from ema_bench_replay.recording import Recording
from ema_twin_sim.plant.balance import balance_response
from ema_twin_sim.plant.layout import STATE
from ema_twin_sim.simulation.assembly import assemble
from ema_twin_sim.simulation.sensor_noise import noise_floors
from ema_twin_sim.simulation.simulate import simulate

PERIOD, COUNT = 0.02, 400


@pytest.mark.parametrize("has_speed", [True, False])
@pytest.mark.parametrize("of_current", [True, False])
def test_nothing_responds_before_the_error_or_long_after_it(stock, has_speed, of_current):
    plant = assemble(stock).plant
    response = balance_response(plant, np.zeros(1, STATE), PERIOD, has_speed, of_current, COUNT)
    assert response[0] == 0.0
    assert np.abs(response).max() > 0.0
    assert np.abs(response[-10:]).max() < 1e-9 * np.abs(response).max()


@pytest.mark.parametrize("has_speed", [True, False])
def test_the_noise_floor_is_the_same_each_time(stock, has_speed):
    found = set()
    for k in range(20):
        spoilt = [np.full(STATE.itemsize, 37 * k % 256, np.uint8) for _ in range(50)]  # freed before the next
        del spoilt
        found.add(noise_floors(stock, has_speed=has_speed, period=PERIOD)["unexplained_torque"])
    assert len(found) == 1


def held(model, current, speed=0.0):
    """The unexplained torque [N m] of a motor at rest, or with that ``speed`` [rad/s] of its sensor's noise."""
    count = len(current)
    signals = {"current": current, "speed": np.broadcast_to(speed, count), "motor_position": np.zeros(count)}
    return simulate(model, Recording("held", np.arange(count) * 2_000_000, signals), "current").signals[
        "unexplained_torque"
    ]


def test_a_bristle_at_rest_balances_what_it_can_hold(stock):
    """No sensor shows how far it bends; more than its sliding level it cannot hold."""
    bristled = stock.with_effect("presliding_friction", {"stiffness": 2.0, "damping": 0.01})
    time = 2e-3 * np.arange(COUNT * 5)
    level = sum(i.parameters["torque"] for i in stock.active.values() if i.effect == "coulomb_friction")
    for share, left in ((0.9, 0.0), (1.5, 0.5)):
        current = share * level / stock.value("machine.torque_constant") * np.sin(1.5 * time)
        assert np.abs(held(bristled, current)[1:]).max() == pytest.approx(left * level, rel=0.01, abs=1e-9)


def test_a_speed_within_its_noise_has_no_direction(stock):
    noise = 0.06
    noisy = stock.with_value("sensors.speed_noise", noise)
    current = np.full(COUNT, 0.02)
    shaken = noise * np.clip(np.random.default_rng(2).standard_normal(COUNT), -1.5, 1.5)
    lags = stock.value("sensors.speed_smoothing") / stock.value("sensors.sample_period")
    assert assemble(noisy).plant["standstill"][0] == pytest.approx(4.0 * noise * np.hypot(1.0 + lags, lags))
    assert assemble(stock).plant["standstill"][0] < noise
    quiet, loud = (np.std(held(model, current, shaken)[10:]) for model in (noisy, stock))
    assert quiet < 0.5 * loud

"""Response of the unexplained torque to the error of one sample, from which its noise floor follows."""

import numpy as np
import pytest

from ema_twin_sim.plant.balance import balance_response
from ema_twin_sim.plant.layout import STATE
from ema_twin_sim.simulation.assembly import assemble
from ema_twin_sim.simulation.compared_signals import noise_floors

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

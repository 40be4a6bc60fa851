"""A measured current that drives a twin without friction: its motion runs away, which says nothing about the model."""

import numpy as np
import pytest

from ema_bench_replay.recording import Recording
from ema_twin_sim.simulation.simulate import simulate

HELD, SECONDS = 3.0, 40.0  # A, s


@pytest.fixture(scope="module")
def free(stock):
    """A model that nothing brakes, of a thousandth of the bench's inertia."""
    for name, effect in stock.effects.items():
        for parameter in ("coefficient", "torque"):
            if parameter in effect.parameters:
                stock = stock.with_value(f"effects.{name}.{parameter}", 0.0)
    for path in ("machine.motor_inertia", "machine.gearbox_inertia", "machine.output_inertia"):
        stock = stock.with_value(path, 1e-3 * stock.value(path))
    return stock


@pytest.fixture(scope="module")
def held_still():
    """Recording of a motor that stands still under a current: a load holds it, which the model does not know."""
    stamps = np.arange(0, round(SECONDS * 1e9), 10_000_000)
    still = np.zeros(len(stamps))
    return Recording("held", stamps, {"current": still + HELD, "speed": still, "motor_position": still})


def test_the_unexplained_torque_is_that_of_the_measured_motion_however_far_the_twin_runs_away(free, held_still):
    twin = simulate(free, held_still, "current").signals
    torque = free.value("machine.torque_constant") * HELD
    fastest = torque / sum(free.value(f"machine.{part}_inertia") for part in ("motor", "gearbox", "output")) * SECONDS
    assert fastest > 1e7  # rad/s, where other simulations are refused
    assert twin["unexplained_torque"][100:] == pytest.approx(torque, rel=1e-6)
    assert np.isfinite(np.array([twin["speed"], twin["motor_position"], twin["output_position"]])).all()

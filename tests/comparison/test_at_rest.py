"""An unexplained torque that is mostly where the machine stands still."""

import numpy as np
import pytest

from ema_twin_sim.comparison.at_rest import at_rest
from ema_twin_sim.comparison.compare import compare
from ema_twin_sim.comparison.where import Stretch
from ema_twin_sim.words.at_rest import at_rest_sentence
from tests.open_motor import open_motor
from tests.recorded import sampled

TIME = np.arange(4000) * 5e-3
NOISE = 1e-3 * np.random.default_rng(2).normal(size=len(TIME))


def stretch(speed, residual):
    return Stretch(residual, speed, np.cumsum(speed), np.cumsum(speed), TIME)


SPEED = np.where(TIME < 12.0, 0.0, 5.0)


@pytest.mark.parametrize(("there", "told"), [(0.3, True), (0.0, False)])
def test_an_error_at_standstill_is_told_with_both_shares(there, told):
    found = at_rest([stretch(SPEED, NOISE + there * (SPEED == 0.0))], 0.1)
    assert (found is not None) == told
    if found is not None:
        assert found.of_samples == pytest.approx(0.6) and found.of_squares > 0.99
        assert found.rest_over_all == pytest.approx(1.29, abs=0.01) and found.motion_over_all < 0.01


@pytest.mark.parametrize("speed", [np.zeros(len(TIME)), np.full(len(TIME), 5.0)])
def test_without_rest_or_without_motion_there_is_nothing_to_tell(speed):
    assert at_rest([stretch(speed, NOISE + 0.3)], 0.1) is None


def test_an_error_of_the_same_size_everywhere_is_not_at_rest():
    mostly_still = np.where(TIME < 18.0, 0.0, 5.0)
    assert at_rest([stretch(mostly_still, NOISE)], 0.1) is None
    assert at_rest([stretch(SPEED, np.full(len(TIME), np.nan))], 0.1) is None


def held(level, inertia=1e-3):
    """A motor that holds a torque up to ``level`` [N m] in turn both ways, then turns against 0.1 N m of friction."""
    turning = np.clip(TIME - 12.0, 0.0, 1.0) * 5.0
    torque = np.where(TIME < 12.0, level * np.sin(1.5 * TIME), 0.1 + inertia * np.gradient(turning, TIME))
    signals = {
        "current": torque + NOISE,
        "speed": turning + NOISE,
        "motor_position": np.concatenate([[0.0], np.cumsum(turning[1:] * np.diff(TIME))]),
    }
    return sampled("held", TIME, signals)


@pytest.mark.parametrize(("level", "told"), [(0.25, True), (0.09, False)])
def test_compare_says_that_a_machine_at_rest_holds_more_than_its_model(level, told):
    model = open_motor(1.0, 1e-3, 5e-3, coulomb=0.1, viscous=1e-4).with_value("machine.motor_inertia", 1e-3)
    comparison = compare([held(level)], model, "current")
    said = at_rest_sentence(comparison)
    assert ("at_rest" in comparison.as_json()) == told
    assert ("where the machine stands still" in said and "larger at rest than in motion" in said) == told

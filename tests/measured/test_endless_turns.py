"""A shaft that turns on and on has no spring: what grows with its travel is what grows with time."""

import numpy as np
import pytest

from ema_twin_sim.measured.observability import not_shown
from ema_twin_sim.model.own_units import OwnUnits, model_in
from tests.recorded import sampled

TIME = np.arange(2000) * 5e-3


def recorded(output, stock):
    """A recording of an output angle (n,) [rad] behind the gear of the bench."""
    signals = {"motor_position": output * stock.value("machine.gear_ratio"), "current": np.ones(len(output))}
    return sampled("run", TIME, signals)


FAN = 50.0 * TIME + 3.0 * np.sin(TIME)
RESTLESS = FAN + 2.0 * np.sin(40.0 * TIME)  # a little way back now and then
THERE_AND_BACK = 5.0 * np.minimum(TIME, TIME[-1] - TIME)
WOUND_UP = 0.5 * TIME  # less than a turn, as in a torsion test
SCREW = 12.0 * TIME  # of a valve, from end to end


@pytest.mark.parametrize(
    ("runs", "hidden"),
    [
        ((FAN,), True),
        ((-FAN, RESTLESS), True),
        ((FAN, THERE_AND_BACK), False),
        ((WOUND_UP,), False),
        ((SCREW, SCREW), False),
    ],
)
def test_no_spring_is_wound_up_without_end(stock, runs, hidden):
    recordings = [recorded(output, stock) for output in runs]
    assert ("spring_load" in not_shown(recordings, stock)) == hidden


def test_a_carriage_makes_no_turns(stock):
    drum = model_in(stock, OwnUnits(radius=0.1))
    assert not not_shown([recorded(FAN, stock)], drum)

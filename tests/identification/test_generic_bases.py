"""Generic bases: a dependence on the direction shows in motion both ways only."""

import numpy as np
import pytest

from ema_twin_sim.identification.generic_bases import beside_generic_bases
from ema_twin_sim.plant.motion import SPEED
from tests.problems import fit_of
from tests.recorded import record


@pytest.mark.parametrize(("command", "both_ways"), [("ramp:0.05", False), ("triangle:0.06:2", True)])
def test_in_one_direction_nothing_depends_on_the_direction(command, both_ways, stock):
    """A table of a motor that turned one way was said to depend on it: on the speed, which is the same there."""
    f = fit_of(record(stock, (command,)), stock)
    speeds = np.concatenate([o.motion[o.rows, SPEED] for o in f.problem.observations])
    assert (speeds.min() < 0.0 < speeds.max()) == both_ways
    bases = beside_generic_bases(f.problem, f).generic_bases
    assert "speed" in bases and ("direction" in bases) == both_ways

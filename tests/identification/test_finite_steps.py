"""Finite differences stay within a number's bounds, to whichever side there is room."""

import numpy as np
import pytest

from ema_twin_sim.identification.equation import EquationErrorProblem
from ema_twin_sim.identification.fit import fit
from ema_twin_sim.identification.jacobian import inner_step
from ema_twin_sim.identification.null_hypothesis import null_hypothesis
from ema_twin_sim.simulation.assembly import longest_delay
from tests.few_rows import few_rows


@pytest.mark.parametrize(
    ("value", "lower", "upper", "step"),
    [
        (0.5, 0.0, 1.0, 0.1),
        (0.0, 0.0, 1.0, 0.1),
        (1.0, 0.0, 1.0, -0.1),
        (0.02, 0.0, 0.08, 0.06),  # neither side has room for a whole step
        (0.07, 0.0, 0.08, -0.07),
    ],
)
def test_a_step_stays_inside(value, lower, upper, step):
    found = inner_step(value, lower, upper, 0.1)
    assert found == pytest.approx(step)
    assert lower <= value + found <= upper


def test_what_is_held_has_a_slope_all_the_same():
    assert abs(inner_step(3.0, 3.0, 3.0, 0.1)) == 0.1


def test_a_delay_as_long_as_the_plant_remembers_is_not_stepped_over(stock):
    quick = stock.with_value("drive.control_cycle", 2e-5)  # whose memory of control cycles is short
    problem = EquationErrorProblem([few_rows(np.zeros(50), encoder=np.zeros(50))])
    late = null_hypothesis(quick).with_effect("encoder_delay", {}, {"delay": longest_delay(quick)})
    assert np.isfinite(fit(problem, late, 0).jacobian).all()


def test_the_step_of_a_small_number_that_is_held_leaves_it_above_zero():
    """An output's inertia that is held at a small share of the file's: none at all would be no machine behind play."""
    assert 0.002 + inner_step(0.002, 0.002, 0.002, 0.01) > 0.0

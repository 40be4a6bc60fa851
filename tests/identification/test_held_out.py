"""Numbers without one recording, to first order, against a fit to the others."""

import numpy as np
import pytest

from ema_twin_sim.identification.equation import EquationErrorProblem
from ema_twin_sim.identification.fit import fit
from ema_twin_sim.identification.null_hypothesis import null_hypothesis
from ema_twin_sim.identification.uncertainty import held_out
from tests.problems import fit_of, problem_of
from tests.recorded import record


def test_what_is_held_makes_up_for_nothing(stock):
    """In one direction friction makes up for a load; where it is held, a load is what a fit to the others finds."""
    recordings = record(stock.with_effect("constant_load", {"torque": 0.03}), ("ramp:0.05", "ramp:0.2", "ramp:0.1"))
    problem = problem_of(recordings, stock)
    constants = null_hypothesis(stock)
    h = constants.holding(constants.by_path).with_effect("constant_load", {}, {"torque": 0.02})
    found = np.array(held_out(problem, fit(problem, h))[0])[:, -1]
    others = [[o for o in problem.observations if o is not left_out] for left_out in problem.observations]
    refitted = np.array([fit(EquationErrorProblem(rest), h).hypothesis.values[-1] for rest in others])
    assert found == pytest.approx(refitted, abs=0.05 * np.ptp(refitted))


def test_the_contact_of_teeth_is_as_good_as_held(stock):
    """Each recording is judged with the contact that all recordings gave, and with what goes with that one."""
    play = {"width": 0.004}
    f = fit_of(record(stock.with_effect("backlash", play), seconds=4.0), stock, backlash=play)
    contact = {path: value for path, value in f.hypothesis.by_path.items() if path.startswith("contact.")}
    held = fit(f.problem, f.hypothesis.holding(contact), 0)
    both = [np.array(held_out(f.problem, one)[0]) for one in (f, held)]
    assert contact and np.abs(both[0] - f.hypothesis.values).max() > 0.0
    assert both[0] == pytest.approx(both[1], rel=1e-9)


def test_what_is_left_of_each_recording_is_that_of_its_numbers(stock):
    f = fit_of(record(stock.with_effect("encoder_delay"), seconds=4.0), stock)
    problem = f.problem
    numbers, left = held_out(problem, f)
    assert not any(np.array_equal(values, f.hypothesis.values) for values in numbers)
    for values, *parts in zip(numbers, problem.torque_parts, problem.encoder_parts, strict=True):
        residual = problem.residual(problem.predict(f.hypothesis.at(values)))
        assert all(np.array_equal(left[part], residual[part]) for part in parts)

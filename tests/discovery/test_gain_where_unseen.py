"""What an effect gains in recordings that it was not fitted to, beside a dependence that only one of them tells."""

import pytest

from ema_twin_sim.discovery.unseen import gain_where_unseen
from ema_twin_sim.identification.equation import EquationErrorProblem
from ema_twin_sim.identification.fit import fit
from ema_twin_sim.identification.generic_bases import beside_generic_bases, fit_with_basis
from ema_twin_sim.identification.null_hypothesis import null_hypothesis
from ema_twin_sim.measured.observe import observe_all
from tests.recorded import record

LOAD = {"torque": 0.03}


def test_what_one_recording_alone_tells_does_not_spoil_it(stock):
    """A dependence on the time of the last recording may be anything to the numbers that the others gave."""
    recordings = record(stock.with_effect("constant_load", LOAD), ("ramp:0.05", "triangle:0.06:2", "sine:0.05:0.4"))
    problem = EquationErrorProblem(observe_all(recordings, stock))
    f = fit(problem, null_hypothesis(stock).with_effect("constant_load", {}, LOAD))
    gained = gain_where_unseen(f)
    problem = beside_generic_bases(problem, f)
    over_time = [name for name in problem.generic_bases if name.startswith("time#")][-1]
    beside = fit_with_basis(problem, fit(problem, f.hypothesis), over_time)
    assert gained > 1000.0
    assert gain_where_unseen(beside) == pytest.approx(gained, rel=0.05)

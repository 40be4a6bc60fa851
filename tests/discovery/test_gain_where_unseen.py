"""What an effect gains in recordings that it was not fitted to, beside a dependence that only one of them tells."""

import pytest

from ema_twin_sim.discovery.unseen import gain_where_unseen
from ema_twin_sim.identification.fit import fit
from ema_twin_sim.identification.generic_bases import beside_generic_bases, fit_with_basis
from tests.problems import fit_of
from tests.recorded import record

LOAD = {"torque": 0.03}


def test_what_one_recording_alone_tells_does_not_spoil_it(stock):
    """A dependence on the time of the last recording may be anything to the numbers that the others gave."""
    f = fit_of(record(stock.with_effect("constant_load", LOAD)), stock, constant_load=LOAD)
    gained = gain_where_unseen(f)
    problem = beside_generic_bases(f.problem, f)
    over_time = [name for name in problem.generic_bases if name.startswith("time#")][-1]
    beside = fit_with_basis(problem, fit(problem, f.hypothesis), over_time)
    assert gained > 1000.0
    assert gain_where_unseen(beside) == pytest.approx(gained, rel=0.05)

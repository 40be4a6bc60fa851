"""What a solution holds: of the weighting that it was found under, and no more work than it took."""

import numpy as np
import pytest

from ema_twin_sim.fitting.equation_misfit import EquationMisfit
from ema_twin_sim.fitting.free_parameters import choose_numbers
from ema_twin_sim.fitting.simulation_misfit import SimulationMisfit
from ema_twin_sim.fitting.solver import refine
from ema_twin_sim.identification.equation import EquationErrorProblem
from ema_twin_sim.measured.observe import observe_all
from tests.fitted_bench import bench


@pytest.fixture(scope="module", params=[EquationMisfit, SimulationMisfit])
def misfit(request, stock):
    """Of a bench with a load that the model lacks."""
    recordings = bench(stock.with_effect("constant_load", {"torque": 0.03}), ("sine:0.05:0.5", "ramp:0.03"), 3.0)
    observations, freedom = observe_all(recordings, stock), choose_numbers(stock, (), ())
    if request.param is EquationMisfit:
        return EquationMisfit(EquationErrorProblem(observations), freedom)
    return SimulationMisfit(recordings, observations, freedom, ["setpoint"] * 2)


def test_slopes_are_those_of_the_residual_whatever_is_weighted_anew_later(misfit):
    start = misfit.freedom.start
    residual = misfit.residual(start)
    weights = misfit.weights(residual)
    slopes = misfit.slopes(start, weights)
    found = refine(misfit, start, 0)
    assert misfit.reweigh(4.0 * residual)
    assert found.residual == pytest.approx(residual * weights)
    per = [number.slope(value) for number, value in zip(misfit.freedom.numbers, start, strict=True)]
    assert found.slopes == pytest.approx(slopes * per, rel=1e-9, abs=1e-9 * np.abs(slopes).max())


def test_a_cost_alone_takes_no_slopes(misfit, monkeypatch):
    monkeypatch.setattr(type(misfit), "slopes", lambda *_: pytest.fail("nobody asked for slopes"))
    start = misfit.freedom.start
    assert refine(misfit, start, 0).misfit == pytest.approx(misfit.cost(misfit.residual(start)))

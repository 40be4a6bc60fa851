"""Friction of the teeth follows the torque they carry, the load's included: in every form of the plant's equations."""

import math

import numpy as np
import pytest

from ema_twin_sim.identification.equation import EquationErrorProblem
from ema_twin_sim.identification.jacobian import jacobian
from ema_twin_sim.identification.null_hypothesis import null_hypothesis
from ema_twin_sim.measured.observe import observe
from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.simulate import simulate
from ema_twin_sim.simulation.virtual_bench import virtual_bench

LOADS = {
    "a weight": ("gravity_load", {"torque": 0.4, "angle": 0.9}),
    "a constant torque": ("constant_load", {"torque": -0.3}),
    "a spring": ("spring_load", {"stiffness": 3.0}),
}
COEFFICIENT = 0.3


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def torque_missed(recording, model):
    """Torque (m,) [N m] by which inverse dynamics misses that of a recording, below the limit of shocks."""
    problem = EquationErrorProblem([observe(recording, model)])
    error = problem.torque - problem.predict(null_hypothesis(model)).rows[: problem.size] * problem.noise
    return error[problem.observations[0].below_shock_limit]


@pytest.fixture(scope="module", params=["rigid", "two_inertia"])
def geared(stock, request):
    """The stock machine with mesh friction, its gearbox stiff or a spring."""
    model = stock.with_effect("mesh_friction", {"coefficient": COEFFICIENT})
    if request.param == "two_inertia":
        model = model.with_effect("shaft_compliance", {"stiffness": 60.0, "damping": 0.2})
    return model


@pytest.mark.parametrize("load", LOADS)
def test_kernel_balance_and_inverse_dynamics_agree(geared, load):
    """What the kernel simulates is explained by the balance and by the inverse dynamics, to a part in a hundred."""
    model = geared.with_effect(*LOADS[load])
    recording = virtual_bench(model, parse_command("speed-sine:0.1:0.5"), 8.0, seed=None)
    moving = np.abs(recording.signals["speed"]) > 1.5
    moving[:250] = False
    torque = model.value("machine.torque_constant") * recording.signals["current"]
    left = simulate(model, recording, "current").signals["unexplained_torque"]
    # away from the reversals, where the filters of the balance smear the step of dry friction
    smeared = np.convolve(~moving, np.ones(101), "same") > 0
    assert rms(left[~smeared]) < 0.01 * rms(torque)
    assert rms(torque_missed(recording, model)) < 0.01 * rms(torque)


def test_the_balance_feels_what_the_load_adds(stock):
    """Without mesh friction in the model, what is left is the coefficient times the whole torque passed on."""
    load = 0.5
    machine = stock.with_effect("constant_load", {"torque": load})
    worn = machine.with_effect("mesh_friction", {"coefficient": COEFFICIENT})
    recording = virtual_bench(worn, parse_command("speed-ramp:0.05"), 4.0, seed=None)
    steady = recording.time > 2.0
    left = simulate(machine, recording, "current").signals["unexplained_torque"][steady]
    own = stock.effects["coulomb_friction_2"].parameters["torque"]
    own += stock.value("machine.output_inertia") * 0.05 * stock.value("machine.gear_ratio")
    assert left.mean() == pytest.approx(COEFFICIENT * (load + own), rel=0.01)
    left = simulate(worn, recording, "current").signals["unexplained_torque"][steady]
    assert math.fabs(left.mean()) < 0.005 * load


def test_a_loads_slopes_hold_what_follows_it(stock):
    """Beside mesh friction, a load asks for its own torque and for the friction that it makes."""
    machine = stock.with_effect("constant_load", {"torque": 0.4}).with_effect("mesh_friction", {"coefficient": 0.3})
    recording = virtual_bench(machine, parse_command("speed-sine:0.1:0.5"), 8.0, seed=None)
    problem = EquationErrorProblem([observe(recording, stock)])
    h = null_hypothesis(stock.with_effect("mesh_friction", {"coefficient": 0.3}))
    h = h.with_effect("constant_load", {}, {"torque": 0.4})
    predicted = problem.predict(h)
    slopes = jacobian(problem, h, predicted, np.ones(problem.rows))
    k = [free.path for free in h.free].index("effects.constant_load.torque")
    more = problem.predict(h.put({h.free[k].path: 0.401})).rows
    assert slopes[: problem.size, k] == pytest.approx(
        ((more - predicted.rows) / 0.001)[: problem.size], rel=0.02, abs=1e-3
    )
    forward = problem.observations[0].motion[problem.observations[0].rows, 2] > 2.0
    assert np.median(slopes[: problem.size, k][forward] * problem.noise[forward]) == pytest.approx(1.3, rel=0.01)

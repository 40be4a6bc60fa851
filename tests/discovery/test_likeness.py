"""An effect that is nearly another leaves less than the noise, and is told from it by the shape of what it leaves."""

import numpy as np
import pytest

from ema_twin_sim.discovery.criteria.explained import depends, explained
from ema_twin_sim.discovery.criteria.likeness import likenesses
from ema_twin_sim.discovery.search.adding import settle
from ema_twin_sim.discovery.search.rivals import with_displaced
from ema_twin_sim.discovery.search.trace import Search
from ema_twin_sim.identification.equation import EquationErrorProblem
from ema_twin_sim.identification.fit import fit
from ema_twin_sim.identification.generic_bases import beside_generic_bases
from ema_twin_sim.identification.null_hypothesis import null_hypothesis
from ema_twin_sim.measured.observe import observe_all
from tests.recorded import record, with_signals

RUNS = ("ramp:0.015", "triangle:0.03:2", "sine:0.05:0.4", "ramp:0.06")
AT_ITS_LARGEST = {"torque": 0.06, "angle": 0.2}  # where the output starts, gravity hardly changes with the angle
LOADED = {"torque": 0.06, "angle": -1.276}


def ended(model, hidden, named):
    """(equation, fit of what is named, fit of nothing), beside recordings of a machine with hidden effects."""
    machine = model
    for effect, parameters in hidden.items():
        machine = machine.with_effect(effect, parameters)
    problem = EquationErrorProblem(observe_all(record(machine, RUNS, seconds=20.0), model))
    h = null_hypothesis(model)
    start = settle(fit(problem, h))
    for effect, parameters in named.items():
        h = h.with_effect(effect, {}, parameters)
    f = settle(fit(problem, h, 20))
    return beside_generic_bases(f.problem, f), f, start


@pytest.mark.parametrize(
    ("hidden", "named"),
    [
        ({"gravity_load": AT_ITS_LARGEST}, {"constant_load": {"torque": 0.06}}),
        ({"spring_load": {"stiffness": 0.06}}, {"gravity_load": {"torque": 0.06, "angle": -1.276}}),
        (
            {"gravity_load": LOADED, "mesh_friction": {"coefficient": 0.3}},
            {"gravity_load": LOADED, "torque_constant_error": {"scale": 0.9}},
        ),
    ],
)
def test_a_likeness_explains_nothing(hidden, named, stock):
    problem, f, start = ended(stock, hidden, named)
    assert depends(problem, f)
    assert not explained(problem, f, start)
    assert set(likenesses(problem, f)) == set(named) - set(hidden)


@pytest.mark.parametrize(
    "hidden",
    [
        {"constant_load": {"torque": 0.06}},
        {"gravity_load": AT_ITS_LARGEST},
        {"spring_load": {"stiffness": 0.06}},
        {"gravity_load": LOADED, "mesh_friction": {"coefficient": 0.3}},
        {"torque_constant_error": {"scale": 0.8}},
    ],
)
def test_the_true_effect_is_no_likeness(hidden, stock):
    problem, f, start = ended(stock, hidden, hidden)
    assert not depends(problem, f)
    assert explained(problem, f, start)
    assert likenesses(problem, f) == ()


def test_what_a_dependence_does_not_make_needless_is_no_likeness(stock):
    """An inertia shows in a constant off its file: what a bump over the speed explains beside it is another matter."""
    inertia = {"inertia": 6e-4}
    kt = stock.value("machine.torque_constant")
    bumped = []
    for recording in record(stock.with_effect("added_inertia", inertia), RUNS, seconds=20.0):
        speed = recording.signals["speed"]
        bump = 0.004 * np.exp(-(((np.abs(speed) - 4.0) / 1.0) ** 2)) * np.sign(speed)
        current = recording.signals["current"] + bump / kt
        bumped.append(with_signals(recording, {**recording.signals, "current": current}))
    problem = EquationErrorProblem(observe_all(bumped, stock))
    f = settle(fit(problem, null_hypothesis(stock).with_effect("added_inertia", {}, inertia), 20))
    problem = beside_generic_bases(f.problem, f)
    assert depends(problem, f)
    assert likenesses(problem, f) == ()


def test_what_a_rival_displaced_comes_back_where_it_is_worth_its_price(stock):
    added = {"constant_load": {"torque": 0.03}, "added_inertia": {"inertia": 6e-4}}
    machine = stock
    for effect, parameters in added.items():
        machine = machine.with_effect(effect, parameters)
    problem = EquationErrorProblem(observe_all(record(machine, RUNS), stock))
    one, other = (
        Search(settle(fit(problem, null_hypothesis(stock).with_effect(effect, {}, parameters))), ())
        for effect, parameters in added.items()
    )
    assert set(with_displaced(one, other).fit.hypothesis.effects) == set(added)

"""An effect that is nearly another leaves less than the noise, and is told from it by the shape of what it leaves."""

import numpy as np
import pytest

from ema_twin_sim.discovery.criteria.explained import depends, explained
from ema_twin_sim.discovery.criteria.likeness import likenesses
from ema_twin_sim.discovery.search.adding import settle
from ema_twin_sim.discovery.search.rivals import with_displaced
from ema_twin_sim.discovery.search.trace import Search
from ema_twin_sim.identification.fit import fit
from ema_twin_sim.identification.generic_bases import beside_generic_bases
from tests.fitted_bench import with_effects
from tests.problems import fit_of, hypothesis_of, problem_of
from tests.recorded import changed, record

RUNS = ("ramp:0.015", "triangle:0.03:2", "sine:0.05:0.4", "ramp:0.06")
AT_ITS_LARGEST = {"torque": 0.06, "angle": 0.2}  # where the output starts, gravity hardly changes with the angle
LOADED = {"torque": 0.06, "angle": -1.276}


def ended(model, hidden, named):
    """(equation, fit of what is named, fit of nothing), beside recordings of a machine with hidden effects."""
    problem = problem_of(record(with_effects(model, hidden), RUNS, seconds=20.0), model)
    start, f = settle(fit(problem, hypothesis_of(model))), settle(fit(problem, hypothesis_of(model, **named), 20))
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
        bumped.append(changed(recording, current=recording.signals["current"] + bump / kt))
    f = settle(fit_of(bumped, stock, 20, added_inertia=inertia))
    problem = beside_generic_bases(f.problem, f)
    assert depends(problem, f)
    assert likenesses(problem, f) == ()


def test_what_a_rival_displaced_comes_back_where_it_is_worth_its_price(stock):
    added = {"constant_load": {"torque": 0.03}, "added_inertia": {"inertia": 6e-4}}
    problem = problem_of(record(with_effects(stock, added), RUNS), stock)
    one, other = (
        Search(settle(fit(problem, hypothesis_of(stock, **{effect: parameters}))), ())
        for effect, parameters in added.items()
    )
    assert set(with_displaced(one, other).fit.hypothesis.effects) == set(added)

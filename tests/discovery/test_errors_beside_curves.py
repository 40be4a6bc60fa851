"""What every machine has keeps errors that say something, beside curves that can do what it does."""

import pytest

from ema_twin_sim.discovery.errors_beside_curves import errors_beside_curves
from ema_twin_sim.identification.estimates import standard_errors
from ema_twin_sim.identification.fit import fit
from ema_twin_sim.identification.generic_bases import beside_generic_bases, dependence
from ema_twin_sim.identification.null_hypothesis import null_hypothesis
from tests.problems import problem_of
from tests.recorded import record

COULOMB = {"torque": 0.1, "static_ratio": 1.0}
TORQUE = "effects.coulomb_friction.torque"


@pytest.fixture
def beside_time(stock):
    """Dry friction found beside one curve over the time of each recording, of a model without dry friction."""
    bare = stock.without_effect("coulomb_friction")
    problem = problem_of(record(stock, ("triangle:0.06:2", "sine:0.05:0.4"), 10.0), bare)
    alone = fit(problem, null_hypothesis(bare).with_effect("coulomb_friction", {"side": "motor"}, COULOMB), 20)
    problem = beside_generic_bases(problem, alone)
    h = alone.hypothesis
    for name, columns in problem.generic_bases.items():
        if dependence(name) == "time":
            h = h.with_generic_basis(name, columns.shape[1])
    return fit(problem, h), alone


def test_dry_friction_is_as_sure_as_it_is_without_the_curves(beside_time):
    f, alone = beside_time
    value = alone.hypothesis.by_path[TORQUE]
    assert standard_errors(f.problem, f)[TORQUE] > value  # the curves can take all of it
    sure = errors_beside_curves(f.problem, f)
    assert sure[TORQUE] == pytest.approx(standard_errors(alone.problem, alone)[TORQUE], rel=0.5)
    others = {path for path in sure if not path.startswith("effects.")}
    assert all(sure[path] == standard_errors(f.problem, f)[path] for path in others)


def test_without_curves_nothing_changes(beside_time):
    _, alone = beside_time
    assert errors_beside_curves(alone.problem, alone) == standard_errors(alone.problem, alone)

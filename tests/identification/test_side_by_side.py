"""Models with play or spring that are simulated side by side move as each does alone, to the last digit."""

import numpy as np
import pytest

from ema_twin_sim.effects import catalogue
from ema_twin_sim.identification.null_hypothesis import null_hypothesis
from ema_twin_sim.plant.measured_motion_many import LANE
from tests.problems import problem_of
from tests.recorded import record


@pytest.fixture(scope="module")
def problem(stock):
    return problem_of(record(stock), stock)


@pytest.mark.parametrize(
    "effects",
    [
        ("backlash",),
        ("shaft_compliance", "gravity_load"),
        ("backlash", "shaft_compliance", "presliding_friction", "mesh_friction", "asymmetric_friction"),
        ("backlash", "encoder_eccentricity", "encoder_delay"),
        ("gravity_load",),  # rigid: one after another
    ],
)
@pytest.mark.parametrize("count", [2, 3, LANE + 3])
def test_rows_are_those_of_each_alone(problem, stock, effects, count):
    h = null_hypothesis(stock)
    for id in effects:
        h = h.with_effect(id, catalogue()[id].default_options(), catalogue()[id].default_parameters())
    h = h.at(np.clip(h.values, *problem.bounds(h)))
    random = np.random.default_rng(count)
    several = [h.at(h.values * random.uniform(0.7, 1.3, len(h.values))) for _ in range(count)]
    for alone, rows in zip(several, problem.rows_of(several), strict=True):
        np.testing.assert_array_equal(rows, problem.predict(alone).rows)

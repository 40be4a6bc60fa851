"""An output encoder later than a first search looks for."""

import pytest

from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.discovery.late_output import longer_delay
from ema_twin_sim.identification.equation import EquationErrorProblem
from ema_twin_sim.identification.fit import fit
from ema_twin_sim.identification.null_hypothesis import null_hypothesis
from ema_twin_sim.measured.observe import observe_all
from tests.recorded import record

LATE = {"delay": 0.024}  # s, 12 samples


def longest(model, stock, excluded=()):
    problem = EquationErrorProblem(observe_all(record(model), stock))
    return longer_delay(problem, fit(problem, null_hypothesis(stock), 0), excluded)


def test_how_late_it_is_shows_in_proportion_to_the_speed(stock):
    """Twice as long is searched, whatever torque is missing besides."""
    for model in (stock, stock.with_effect("stribeck_friction"), stock.with_effect("gravity_load")):
        assert longest(model.with_effect("encoder_delay", LATE), stock) == pytest.approx(0.048, rel=0.02)


@pytest.mark.parametrize(
    ("effect", "parameters"),
    [
        ("encoder_delay", {"delay": 0.006}),  # that is tried at first
        ("backlash", {"width": 0.02}),
        ("shaft_compliance", {}),
        ("encoder_eccentricity", {}),
        ("cogging", {}),
    ],
)
def test_nothing_else_is_taken_for_a_late_encoder(effect, parameters, stock):
    assert longest(stock.with_effect(effect, parameters), stock) is None


def test_a_delay_that_may_not_be_named_is_not_searched_for(stock):
    machine = stock.with_effect("encoder_delay", LATE)
    assert longest(machine, stock, ("encoder_delay",)) is None
    assert longest(machine, stock.with_effect("encoder_delay", {"delay": 0.004})) is None  # the model has one


@pytest.mark.slow
@pytest.mark.parametrize("beside", [(), ("stribeck_friction",)])
def test_it_is_named_with_its_delay(beside, stock):
    machine = stock.with_effect("encoder_delay", LATE)
    for effect in beside:
        machine = machine.with_effect(effect)
    found = discover(record(machine), stock)
    assert found.verdict == "explained" and {*found.added} == {"encoder_delay", *beside}
    assert found.parameters["encoder_delay"]["delay"]["value"] == pytest.approx(0.024, rel=0.01)

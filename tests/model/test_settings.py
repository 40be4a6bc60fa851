"""Settings of a running twin, several at once: the law of an effect has parameters of its own."""

import pytest

from ema_bench_replay.errors import InputError
from ema_twin_sim.simulation.twin import Twin

ANGLE, RELAXED, STIFFNESS = (f"effects.spring_load.{name}" for name in ("angle", "relaxed", "stiffness"))


@pytest.fixture
def sprung(stock):
    return stock.with_effect("spring_load", {"stiffness": 0.05})


@pytest.mark.parametrize("names", [(ANGLE, RELAXED), (RELAXED, ANGLE)])
def test_a_law_is_set_before_its_parameters(names, sprung):
    settings = {ANGLE: -2.0, RELAXED: "angle"}
    placed = sprung.with_settings({name: settings[name] for name in names}).effects["spring_load"]
    assert placed.options == {"relaxed": "angle"} and placed.parameters == {"stiffness": 0.05, "angle": -2.0}


def test_a_twin_states_the_parameters_of_all_laws(sprung):
    """And takes its own settings back, as the monitor does that diagnoses it."""
    twin = Twin(sprung, "setpoint")
    told = {each.path: each.value for each in twin.parameters() if each.path in (ANGLE, STIFFNESS)}
    assert told == {STIFFNESS: 0.05, ANGLE: 0.0}
    assert sprung.with_settings(told).effects == sprung.effects
    twin.change({ANGLE: 0.0, STIFFNESS: 0.06})
    assert twin.effects["spring_load"].parameters == {"stiffness": 0.06}


def test_a_parameter_of_another_law_is_refused(sprung):
    with pytest.raises(InputError, match="has no parameter 'angle' with relaxed: start; choose relaxed: angle"):
        sprung.with_settings({ANGLE: -2.0})


def test_another_law_keeps_what_both_have(sprung):
    placed = sprung.with_settings({RELAXED: "angle", ANGLE: -2.0})
    back = placed.with_settings({RELAXED: "start"})
    assert back.effects["spring_load"].parameters == {"stiffness": 0.05}

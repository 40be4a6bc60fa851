"""A measured load tells the torque constant: within its tolerance it is a refitted constant, beyond it an effect."""

from dataclasses import replace

import pytest

from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.discovery.torque_constant import with_factor_in_the_constant
from ema_twin_sim.identification.null_hypothesis import null_hypothesis
from ema_twin_sim.model import load_model, save_model
from tests.discovery.test_measured_load import braked, without_load
from tests.opened import all_open

CONSTANT = "machine.torque_constant"


def of_a_motor(stock, scale):
    """Two runs against a measured load of a machine whose motor gives ``scale`` times the model's torque."""
    weaker = stock.with_effect("torque_constant_error", {"scale": scale})
    return [braked(weaker, 1), braked(weaker, 2, rate=0.5)]


@pytest.mark.slow
def test_within_its_tolerance_it_is_a_constant(stock, tmp_path):
    assert stock.constants[CONSTANT].tolerance == 0.05
    found = discover(of_a_motor(stock, 0.97), stock)
    assert (found.verdict, found.added) == ("none", ())
    part, name = stock.shown_path(CONSTANT).split(".")
    entry = found.constants[part][name]
    assert entry["value"] == pytest.approx(0.97 * entry["nominal"], abs=3.0 * entry["std"])
    assert entry["std"] < 0.01 * entry["nominal"]
    assert found.model.value(CONSTANT) == entry["value"] and found.model.effects.keys() == stock.effects.keys()
    assert found.left["current"]["rmse"] < 1.3 * found.left["current"]["noise_floor"]
    written = save_model(found.model, tmp_path / "model.yaml")
    assert load_model(written).value(CONSTANT) == pytest.approx(entry["value"])


@pytest.mark.slow
def test_beyond_it_an_effect_is_missing(stock):
    found = discover(of_a_motor(stock, 0.85), stock)
    assert found.added == ("torque_constant_error",) and found.verdict == "explained"
    scale = found.parameters["torque_constant_error"]["scale"]
    assert scale["value"] == pytest.approx(0.85, abs=0.01)
    assert found.model.value(CONSTANT) == stock.value(CONSTANT)


@pytest.mark.slow
@pytest.mark.parametrize("scale", [0.3, 0.07])
def test_far_beyond_it_is_none_of_its_tolerance_however_unsure_it_is(scale, stock):
    """The effect ends on its bound; its error is then as large as itself, and within that it was no error at all."""
    wrong = all_open(stock).with_value(CONSTANT, stock.value(CONSTANT) / scale)
    found = discover(of_a_motor(stock, 1.0), wrong)
    assert "torque_constant_error" in found.added and found.verdict == "unknown"
    assert found.model.value(CONSTANT) == wrong.value(CONSTANT)


@pytest.mark.slow
def test_without_the_sensor_nothing_tells_it(stock):
    assert discover([without_load(run) for run in of_a_motor(stock, 0.97)], stock).added != ("torque_constant_error",)


@pytest.mark.slow
def test_an_assumed_constant_of_an_unknown_machine_is_fitted_however_far_off(stock):
    """Nobody took the 1 N m/A of a draft for a number of the machine."""
    assumed = replace(stock.constants[CONSTANT].at(8.0 * stock.value(CONSTANT)), source="assumed: 1 N m/A")
    drafted = all_open(stock)
    drafted = replace(drafted, constants={**drafted.constants, CONSTANT: assumed})
    found = discover(of_a_motor(stock, 1.0), drafted)
    assert (found.verdict, found.added) == ("none", ())
    assert found.model.value(CONSTANT) == pytest.approx(stock.value(CONSTANT), rel=0.01)
    part, name = stock.shown_path(CONSTANT).split(".")
    assert found.constants[part][name]["std"] < 0.01 * stock.value(CONSTANT)


def test_a_disabled_factor_of_the_model_stays_as_it_is(stock):
    """The constant that is fitted is another instance's."""
    scaled = stock.with_effect("torque_constant_error", {"scale": 0.8})
    (own,) = scaled.effects.keys() - stock.effects.keys()
    asleep = replace(scaled, effects={**scaled.effects, own: replace(scaled.effects[own], enabled=False)})
    h = null_hypothesis(asleep).with_effect("torque_constant_error", {}, {"scale": 0.97})
    (added,) = h.added
    model = h.with_factor_as_constant(added, 0.05).put({"scale.torque_constant_error": 0.96}).model()
    assert model.effects[own] == asleep.effects[own]
    assert model.effects[added].parameters["scale"] == 0.96


def test_a_factor_of_the_given_model_or_added_by_a_search_stays_an_effect(stock):
    scaled = stock.with_effect("torque_constant_error", {"scale": 0.9})
    assert with_factor_in_the_constant(scaled, scaled, scaled) is scaled
    assert with_factor_in_the_constant(scaled, stock, stock) is scaled
    told = with_factor_in_the_constant(scaled, scaled, stock)
    assert told.value(CONSTANT) == pytest.approx(0.9 * stock.value(CONSTANT)) and told.effects == stock.effects

"""The step of simulations of which only differences matter: twice the default, where the model allows it.

That this is converged is a test of the plant.
"""

import dataclasses

import pytest

from ema_twin_sim.model import load_model
from ema_twin_sim.simulation.fidelity import DEFAULT_STEP
from ema_twin_sim.simulation.longest_step import coarse_step


def changed(model, path, value):
    return dataclasses.replace(model, constants={**model.constants, path: model.constants[path].at(value)})


def test_it_is_twice_the_default(stock):
    assert coarse_step(stock) == 2.0 * DEFAULT_STEP


def test_a_shorter_control_cycle_has_as_many_steps(stock):
    assert coarse_step(changed(stock, "drive.control_cycle", 1e-4)) == pytest.approx(4e-5)
    assert coarse_step(changed(stock, "drive.control_cycle", 5e-5)) is None


def test_stiff_teeth_and_fine_models_keep_their_own(stock):
    geared = stock.with_effect("backlash", {"width": 1e-3})
    assert coarse_step(geared) == 2.0 * DEFAULT_STEP
    stiff = changed(geared, "transmission.contact_stiffness", 300.0 * geared.value("transmission.contact_stiffness"))
    assert coarse_step(stiff) is None
    assert coarse_step(load_model("polito_hf")) is None

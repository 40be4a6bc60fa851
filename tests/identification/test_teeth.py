"""The teeth that a model file gives, or those of the reference bench where it gives none."""

from dataclasses import replace

import pytest

from ema_twin_sim.identification.hypothesis import null_hypothesis
from ema_twin_sim.measured.scales import INERTIAS

STIFFNESS = "transmission.contact_stiffness"


def teeth(model):
    return null_hypothesis(model).with_effect("backlash", {}, {"width": 0.1}).teeth_of_the_file()


def lighter(model, times):
    inertias = {path: model.constants[path].at(model.value(path) / times) for path in INERTIAS}
    return replace(model, constants={**model.constants, **inertias})


def test_they_are_the_files(stock):
    given = replace(stock.constants[STIFFNESS], value=3000.0, source="measured")
    told = teeth(replace(stock, constants={**stock.constants, STIFFNESS: given}))
    assert told == pytest.approx({"contact.stiffness": 3000.0, "contact.damping": 1.0})


def test_wheels_too_light_for_the_reference_benchs_have_none(stock):
    """A simulation would need steps of nanoseconds."""
    assert teeth(lighter(stock, 2.0)).keys() == {"contact.stiffness", "contact.damping"}
    assert teeth(lighter(stock, 1e5)) == {}


def test_teeth_that_the_file_gives_are_taken_however_light_the_wheels(stock):
    constants = {
        path: replace(constant, source="measured") if path.startswith("transmission.contact") else constant
        for path, constant in stock.constants.items()
    }
    assert teeth(lighter(replace(stock, constants=constants), 1e5))["contact.stiffness"] > 0.0

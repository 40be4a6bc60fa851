"""The teeth that a model file gives, or those of the reference bench where it gives none."""

from dataclasses import replace

from ema_twin_sim.identification.null_hypothesis import null_hypothesis
from ema_twin_sim.measured.scales import INERTIAS
from ema_twin_sim.model.model_file import ABSENT

CONTACT = "transmission.contact"
TEETH = {"contact.stiffness", "contact.damping"}


def teeth(model):
    return null_hypothesis(model).with_effect("backlash", {}, {"width": 0.1}).teeth_of_the_file()


def lighter(model, times):
    inertias = {path: model.constants[path].at(model.value(path) / times) for path in INERTIAS}
    return replace(model, constants={**model.constants, **inertias})


def without_teeth(model):
    constants = {path: replace(held, source=ABSENT) for path, held in model.constants.items() if CONTACT in path}
    return replace(model, constants={**model.constants, **constants})


def test_they_are_the_files_however_light_the_wheels(stock):
    told = {path: stock.value(f"transmission.{path.replace('.', '_')}") for path in TEETH}
    assert teeth(stock) == teeth(lighter(stock, 1e5)) == told


def test_wheels_too_light_for_the_reference_benchs_have_none(stock):
    """A simulation would need steps of nanoseconds."""
    bare = without_teeth(stock)
    assert teeth(bare).keys() == teeth(lighter(bare, 2.0)).keys() == TEETH
    assert teeth(lighter(bare, 1e5)) == {}

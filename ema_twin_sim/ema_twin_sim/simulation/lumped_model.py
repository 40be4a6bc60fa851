"""The model with averaged drive and two inertias that replaces a finer one when many runs are needed."""

from __future__ import annotations

from dataclasses import replace

from ..effects import backlash, mesh_friction, shaft_compliance
from ..model import Model
from .assembly import assemble
from .fidelity import is_fine
from .lumped_train import lump_train

_CONTACT = ("contact_stiffness", "contact_damping")


def lumped_model(model: Model) -> Model:
    """A model that runs with steps of a control cycle: averaged drive, and the planetary train as in ``lump_train``.

    A model that is not finer is returned unchanged.
    """
    if not is_fine(model):
        return model
    averaged = replace(model, kinds={**model.kinds, "drive": "averaged"})
    if model.kinds["transmission"] != "planetary":
        return averaged
    assembly = assemble(model)
    plant = assembly.plant[0]
    found = replace(averaged, kinds={**averaged.kinds, "transmission": "two_inertia"})
    for name in (backlash.EFFECT.id, shaft_compliance.EFFECT.id):  # both are already in the plant's spring and gap
        if name in found.effects:
            found = found.without_effect(name)
    for name in _CONTACT:
        found = found.with_value(f"transmission.{name}", float(plant[name]))
    if plant["gap"] > 0.0:
        found = found.with_effect(backlash.EFFECT.id, {"width": 2.0 * float(plant["gap"] / plant["gear_ratio"])})
    loss = lump_train(model, plant.copy(), assembly.fine)
    return found.with_effect(mesh_friction.EFFECT.id, {"coefficient": loss})

"""Traits: rules ask an effect for what they need to know of it, and name none."""

import ast
import re

import pytest

from docs.figures.imports import PACKAGE
from ema_bench_replay.errors import InputError
from ema_twin_sim.effects import Trait, catalogue, effects_with, the_effect
from ema_twin_sim.model import roles
from ema_twin_sim.own_effects import load_effects

TELLS = {"effects", "commands", "report", "views", "words", "entry.py"}
"""Folders that show effects, and may name one in an example."""
ALLOWED = {
    "plant/layout.py": {"encoder_delay"},  # a column of the plant's record
    "plant/sensors.py": {"encoder_delay"},  # the same column
    "identification/equation.py": {"encoder_delay"},  # the same column
    "identification/prediction.py": {"encoder_delay"},  # the same column
    "simulation/assembly.py": {"encoder_delay"},  # the same column
    "model/planetary_constants.py": {"mesh_friction"},  # a choice of the model's file
    "simulation/fidelity.py": {"mesh_friction"},  # the same choice
    "model/matching.py": {"spring_load"},  # a sentence that says what to look for
    "campaign/histories.py": {"backlash"},  # an example in a refusal
    "campaign/sweep.py": {"backlash"},  # an example in a refusal
}
OWN = """
from ema_twin_sim.effects import Effect, Parameter, Trait

def act(at, p):
    return p[0]

EFFECT = Effect(
    id="a_weight", summary="s", equation="e", signature="s", source="s", act=act, depends_on="direction",
    parameters=(Parameter("torque", "N m", 0.03, -1.0, 1.0, "d"),), traits=({traits}),
)
"""


def named(file):
    """The ids of effects within a file's strings, docstrings left out."""
    text = file.read_text()
    if not any(effect in text for effect in catalogue()):
        return set()
    tree = ast.parse(text)
    told = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    texts = [n.value for n in ast.walk(tree) if isinstance(n, ast.Constant) and id(n) not in told]
    pattern = re.compile(rf"\b(?:{'|'.join(catalogue())})\b")
    return {found for text in texts if isinstance(text, str) for found in pattern.findall(text)}


def test_no_rule_names_an_effect():
    files = {file.relative_to(PACKAGE): file for file in sorted(PACKAGE.rglob("*.py"))}
    rules = {str(place): named(file) for place, file in files.items() if place.parts[0] not in TELLS}
    assert len(rules) > 250
    assert {place: names for place, names in rules.items() if names} == ALLOWED


@pytest.mark.parametrize("trait", Trait)
def test_each_trait_is_of_some_effect_and_read_by_some_rule(trait):
    assert effects_with(trait)
    rules = [file.read_text() for file in PACKAGE.rglob("*.py") if file.parent.name != "effects"]
    assert any(f"Trait.{trait.name}" in text for text in rules)


def test_what_estimation_is_built_on_is_one_effect_each():
    assert len({*roles.FRICTION, *roles.COMPLIANT_EFFECTS, roles.SENSOR_DELAY, roles.SENSOR_WAVE}) == 6
    assert all(catalogue()[id].every_machine for id in roles.FRICTION)
    assert catalogue()[roles.SENSOR_DELAY].delays
    assert catalogue()[roles.SENSOR_WAVE].wave_angle is not None
    with pytest.raises(ValueError, match="too many"):
        the_effect(Trait.LOAD)


def test_a_users_own_effect_has_traits_too(tmp_path):
    file = tmp_path / "a_weight.py"
    file.write_text(OWN.format(traits="Trait.LOAD,"))
    load_effects([file])
    assert "a_weight" in effects_with(Trait.LOAD)
    assert "a_weight" not in effects_with(Trait.TRANSIENT)


def test_a_trait_that_is_none_is_refused(tmp_path):
    file = tmp_path / "a_weight.py"
    file.write_text(OWN.format(traits="'load',"))
    with pytest.raises(InputError, match=r"a_weight.*traits: give members of Trait, not 'load'"):
        load_effects([file])

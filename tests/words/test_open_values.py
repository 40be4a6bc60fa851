"""What a draft does not know yet is said before its errors are."""

from dataclasses import replace

from ema_twin_sim.model.check_comment import START_VALUE
from ema_twin_sim.words.open_values import open_values_sentence
from tests.open_motor import open_motor


def test_start_values_are_named_until_they_are_found():
    motor = open_motor(0.05, 0.004, 1e-3)
    (path,) = (path for path in motor.constants if path.endswith("motor_inertia"))
    drafted = replace(motor.constants[path], source=START_VALUE)
    draft = replace(motor, name="draft", constants={**motor.constants, path: drafted})
    said = open_values_sentence(draft)
    assert said.startswith("Model draft: inertia, viscous friction, Coulomb friction and ")
    assert said.endswith("Run discover or fit first: both find these numbers.")
    found = replace(drafted, source="fitted; 0.001 before")
    assert open_values_sentence(replace(draft, constants={**motor.constants, path: found})) == ""

"""What a draft does not know yet is said before its errors are."""

from dataclasses import replace

import numpy as np

from ema_bench_replay.recording import Recording
from ema_twin_sim.model.check_comment import START_VALUE
from ema_twin_sim.words.open_values import open_values_sentence
from tests.open_motor import open_motor


def recorded(*signals):
    stamps = np.arange(10) * 1_000_000
    return Recording("run", stamps, {name: np.zeros(10) for name in signals}, motor_angle_origin=0.0)


def test_start_values_are_named_until_they_are_found():
    motor = open_motor(0.05, 0.004, 1e-3)
    (path,) = (path for path in motor.constants if path.endswith("motor_inertia"))
    drafted = replace(motor.constants[path], source=START_VALUE)
    draft = replace(motor, name="draft", constants={**motor.constants, path: drafted})
    run = recorded("current", "motor_position")
    said = open_values_sentence(draft, [run])
    assert said.startswith("Model draft: inertia, viscous friction, Coulomb friction and ")
    assert said.endswith("Run discover or fit first: both find these numbers.")
    found = replace(drafted, source="fitted; 0.001 before")
    assert open_values_sentence(replace(draft, constants={**motor.constants, path: found}), [run]) == ""


def test_without_a_torque_nothing_is_said_to_find_them():
    """They are start values after a discovery as well, which was to be run first."""
    motor = open_motor(0.05, 0.004, 1e-3)
    (path,) = (path for path in motor.constants if path.endswith("motor_inertia"))
    drafted = replace(motor.constants[path], source=START_VALUE)
    draft = replace(motor, name="draft", constants={**motor.constants, path: drafted})
    encoders = recorded("motor_position", "output_position")
    said = open_values_sentence(draft, [encoders])
    assert "no current or torque was recorded" in said and "Run discover" not in said
    for torque in ("current", "motor_torque"):
        assert "Run discover or fit first" in open_values_sentence(draft, [encoders, recorded(torque)])

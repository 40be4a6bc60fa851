"""``add``: what it prints of the effect that it added."""

import pytest

from tests.command_line import done


@pytest.mark.parametrize(
    ("effect", "model", "line"),
    [
        ("shear_thinning", "emps", "speed = 10 m/s"),
        ("shear_thinning", "polito_bench", "speed = 10 rad/s"),
        ("constant_load", "emps_mass", "torque = 0.03 N ("),
        ("constant_load", "polito_bench", "torque = 0.03 N m ("),
        ("torque_ripple", "emps", "phase = 0 rad"),
    ],
)
def test_a_parameter_has_the_unit_of_its_machine(tmp_path, effect, model, line):
    assert line in done("add", effect, "--model", model, "-o", tmp_path / "new.yaml").stdout

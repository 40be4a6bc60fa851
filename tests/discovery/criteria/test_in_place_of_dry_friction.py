"""No friction takes the place of the machine's dry friction, which is open and is there without it."""

import numpy as np
import pytest

from ema_bench_replay.recording import Recording
from ema_twin_sim.discovery.criteria.in_place_of_dry_friction import in_place_of_dry_friction
from ema_twin_sim.identification.fit import fit
from ema_twin_sim.identification.null_hypothesis import null_hypothesis
from tests.large_arm import open_arm
from tests.problems import problem_of


@pytest.fixture(scope="module")
def arm():
    return open_arm().without_effect("gravity_load")


def swings(arm, dry, mesh):
    """Two swings of an arm with a constant load of 50 N m, its dry friction, and friction in proportion to the load."""
    found = []
    for rate in (0.8, 1.3):
        time = np.arange(10_000) * 2e-3
        angle, speed, acceleration = (1.5 * rate**k * np.sin(rate * time + k * np.pi / 2) for k in range(3))
        torque = 40.0 * acceleration + 30.0 * speed + 50.0
        torque += np.sign(speed) * (dry + mesh * np.abs(torque - 30.0 * speed))
        torque += 0.5 * np.random.default_rng(4).standard_normal(len(time))
        signals = {"current": torque / arm.value("machine.torque_constant"), "speed": speed, "motor_position": angle}
        stamps = np.arange(len(time)) * 2_000_000
        found.append(Recording(f"swing_{rate:g}", stamps, signals, motor_angle_origin=0.0, output_angle_origin=0.0))
    return found


def judged(arm, dry, mesh, level):
    """What the rule says of mesh friction beside a dry friction of the model that ended at ``level`` of its file's."""
    problem = problem_of(swings(arm, dry, mesh), arm)
    h = null_hypothesis(arm).with_effect("constant_load", {}, {"torque": 50.0})
    h = h.with_effect("mesh_friction", {}, {"coefficient": 0.2})
    h = h.put({"scale.coulomb_friction": level})
    return in_place_of_dry_friction(problem, fit(problem, h, 0), "mesh_friction")


def test_what_stands_for_all_of_it_goes(arm):
    assert judged(arm, dry=15.0, mesh=0.0, level=0.0)


def test_what_stands_beside_it_stays(arm):
    assert not judged(arm, dry=15.0, mesh=0.1, level=15.0)


def test_only_friction_can_take_its_place(arm):
    problem = problem_of(swings(arm, 15.0, 0.0), arm)
    h = null_hypothesis(arm).with_effect("constant_load", {}, {"torque": 50.0}).put({"scale.coulomb_friction": 0.0})
    assert not in_place_of_dry_friction(problem, fit(problem, h, 0), "constant_load")

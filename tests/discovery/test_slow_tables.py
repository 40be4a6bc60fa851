"""Friction at constant speeds of slow machines: no speed in rad/s says which point is at rest."""

from dataclasses import replace

import numpy as np
import pytest

from ema_bench_replay.recording import POINTS, Recording
from ema_twin_sim.comparison.compare import compare
from ema_twin_sim.discovery.diagnose import diagnose
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.fitting.fit import fit_model
from ema_twin_sim.model import load_model
from ema_twin_sim.model.own_units import OwnUnits, model_in, recording_in
from ema_twin_sim.simulation.operating_points import directed, moves

VISCOUS, DRY, STRIBECK, FADES, WEIGHT = 2e-3, 0.08, 0.05, 6.0, 0.01  # N m s/rad, N m, N m, rad/s, N m
NOISE = 6e-4  # N m

OPEN = """version: 1
machine:
  name: joint
  inertia: {value: 0.001, unit: kg m^2, tolerance: open, source: start value}
transmission: {kind: rigid}
sensors:
  current_noise: {value: 0.0006, unit: A, source: its readings}
effects:
  viscous_friction: {effect: viscous_friction, options: {side: motor}, parameters: {coefficient: 0.01}, open: true}
  coulomb_friction:
    {effect: coulomb_friction, options: {side: motor}, parameters: {torque: 0.1, static_ratio: 1.0}, open: true}
"""

SLOW, FAST, HUGE = (OwnUnits(time, torque) for time, torque in ((4e-4, 0.02), (300.0, 5.0), (3e4, 1e-4)))
"""Units in which the same numbers are those of a machine that is 2500 times as slow, 300 times as fast, and so on."""


@pytest.fixture(scope="module")
def joint(tmp_path_factory):
    place = tmp_path_factory.mktemp("joint") / "joint.yaml"
    place.write_text(OPEN)
    return load_model(place)


def points(**signals):
    count = len(next(iter(signals.values())))
    return Recording("table", np.arange(count) * 1_000_000_000, signals, motor_angle_origin=0.0,
                     metadata={POINTS: "yes"})  # fmt: skip


@pytest.fixture(scope="module")
def curve():
    """Both ways, from a thousandth of the fastest speed on: most of the fading friction is at the slow ones."""
    rng = np.random.default_rng(3)
    speed = np.concatenate([sign * np.geomspace(0.15, 150.0, 70) for sign in (1.0, -1.0)])
    torque = VISCOUS * speed + np.sign(speed) * (DRY + STRIBECK * np.exp(-np.abs(speed) / FADES)) + WEIGHT
    return points(speed=speed, motor_torque=torque + NOISE * rng.standard_normal(len(speed)))


def similar(recording, model, units):
    """The recording and the model of the similar machine, in SI."""
    return recording_in(recording, units), replace(model_in(model, units), units=None)


def numbers(model):
    return {(i.effect, name): value for i in model.active.values() for name, value in i.parameters.items()}


def alike(found, reference, units):
    """Whether numbers of a similar machine, by effect and name, are those of the reference."""
    powers = {"coefficient": "N m s/rad", "torque": "N m", "speed": "rad/s", "static_ratio": "1"}
    own = {key: value * units.factor(powers[key[1]]) for key, value in found.items()}
    return own == pytest.approx(reference, rel=1e-4)


@pytest.fixture(scope="module")
def reference(curve, joint):
    return discover([curve], joint)


def test_what_a_slow_machines_points_lack_is_named(curve, joint, reference):
    assert (reference.verdict, {*reference.added}) == ("explained", {"stribeck_friction", "constant_load"})
    found = numbers(reference.model)
    assert found["viscous_friction", "coefficient"] == pytest.approx(VISCOUS, rel=0.05)
    assert found["coulomb_friction", "torque"] == pytest.approx(DRY, rel=0.05)
    assert found["stribeck_friction", "torque"] == pytest.approx(STRIBECK, rel=0.05)
    assert found["stribeck_friction", "speed"] == pytest.approx(FADES, rel=0.1)
    assert found["constant_load", "torque"] == pytest.approx(WEIGHT, rel=0.05)


@pytest.mark.parametrize("units", [SLOW, FAST, HUGE])
def test_similar_machines_get_the_same_answer(curve, joint, reference, units):
    """Of discover and compare; in SI the slowest point of these turns at 60 µrad/s to 4500 rad/s."""
    recording, model = similar(curve, joint, units)
    found = discover([recording], model)
    assert (found.verdict, found.added) == (reference.verdict, reference.added)
    assert alike(numbers(found.model), numbers(reference.model), units)
    assert found.unseen.rmse[-1] * units.torque == pytest.approx(reference.unseen.rmse[-1], rel=1e-4)
    for one, other in ((model, joint), (found.model, reference.model)):
        error, expected = compare([recording], one).overall, compare([curve], other).overall
        assert error["motor_torque"]["rmse"] * units.torque == pytest.approx(expected["motor_torque"]["rmse"], rel=1e-4)


@pytest.mark.parametrize("units", [SLOW, FAST])
def test_similar_machines_are_fitted_and_diagnosed_alike(curve, joint, reference, units):
    recording, model = similar(curve, joint, units)
    fitted, of_reference = fit_model([recording], model), fit_model([curve], joint)
    assert alike(numbers(fitted.model), numbers(of_reference.model), units)
    ranks = [[one.effect for one in diagnose([r], m).ranking[:3]] for r, m in ((recording, model), (curve, joint))]
    assert ranks[0] == ranks[1]


def test_no_inertia_decides_where_nothing_accelerates(curve, joint, reference):
    heavier = joint.with_value("machine.motor_inertia", 1e3 * joint.value("machine.motor_inertia"))
    found = discover([curve], heavier)
    assert found.added == reference.added
    assert numbers(found.model) == pytest.approx(numbers(reference.model), rel=1e-4)


def test_an_error_of_a_torque_is_a_torque(curve, joint, reference):
    assert (reference.unseen.signal, reference.unseen.unit) == ("motor_torque", "N m")
    assert reference.unseen.rmse[-1] == pytest.approx(NOISE, rel=0.3)
    assert {name for name, error in fit_model([curve], joint).after.items() if not error["driven"]} == {"motor_torque"}


def test_a_point_is_at_rest_where_its_readings_noise_says_so():
    """Not where it is slow: the slowest points of a table keep their own direction."""
    speed = np.array([0.0, 1e-4, -1e-4, 0.2, -0.2])
    assert np.sign(directed(points(speed=speed)).signals["speed"]) == pytest.approx(np.sign(speed))
    assert np.sign(directed(points(speed=speed), 1e-3).signals["speed"]) == pytest.approx([0, 0, 0, 1, -1])
    position = np.array([0.0, 1.0, 0.5, 2.0, 1.0])
    way = directed(points(speed=speed, motor_position=position)).signals["speed"]
    assert np.sign(way) == pytest.approx([0, 1, -1, 1, -1])  # as they were approached
    assert np.abs(way[1:3]).max() < 1e-4 * np.abs(speed).max()
    assert moves(points(speed=speed)) and not moves(points(speed=speed), 0.1)
    assert not moves(points(motor_position=position))


def test_the_direction_of_a_point_is_found_once():
    """A part of a table does not show how its points were approached."""
    whole = directed(points(motor_position=np.array([0.0, 1.0, 2.0, 1.0, 0.0])))
    part = replace(whole, stamps=whole.stamps[:-2], signals={n: v[2:] for n, v in whole.signals.items()})
    assert directed(part).signals["speed"] == pytest.approx(whole.signals["speed"][2:])

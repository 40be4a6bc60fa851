"""Torsion tests: the output clamped, the motor turned by a part of a turn, slowly. What gives way is a spring to it."""

import math

import numpy as np
import pytest

from ema_bench_replay.recording import Recording
from ema_twin_sim.comparison.compare import compare
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.model import load_model

DRAFT = """
version: 1
machine:
  name: clamped
  inertia: {value: 0.001, unit: kg m^2, tolerance: open}
transmission: {kind: rigid}
sensors:
  motor_encoder_counts: {value: 16384, unit: 1/rev, tolerance: 0.0}
  sample_period: {value: 0.002, unit: s, tolerance: 0.0}
effects:
  viscous_friction: {effect: viscous_friction, options: {side: motor}, parameters: {coefficient: 0.01}, open: true}
  coulomb_friction: {effect: coulomb_friction, options: {side: motor}, parameters: {torque: 0.1, static_ratio: 1.0},
    open: true}
"""
STEP = 2e-4  # s


def wound_up(stiffness, friction, by_load=0.0, gap=0.0, *, furthest=0.5, period=6.0, viscous=2e-3, noise=2e-3):
    """A motor on a stiff position loop that follows a triangle, wound up against its clamped output [N m, rad, s].

    Quasi-static: the torque is that of the spring beyond its gap, and of friction against the motion.
    """
    time = np.arange(0.0, 2.5 * period, 10 * STEP)
    phase = np.arcsin(np.sin(2.0 * math.pi * time / period)) * 2.0 / math.pi
    angle = furthest * phase
    speed = np.gradient(angle, time)
    twist = np.sign(angle) * np.maximum(np.abs(angle) - 0.5 * gap, 0.0)
    spring = stiffness * twist
    against = (friction + by_load * np.abs(spring)) * np.sign(speed) + viscous * speed
    random = np.random.default_rng(3)
    count = 2.0 * math.pi / 16384
    signals = {
        "motor_torque": spring + against + noise * random.standard_normal(len(time)),
        "motor_position": np.round(angle / count) * count,
        "output_position": np.zeros(len(time)),
    }
    return Recording("torsion", np.rint(1e9 * time).astype(np.int64), signals)


@pytest.fixture(scope="module")
def draft(tmp_path_factory):
    path = tmp_path_factory.mktemp("torsion") / "clamped.yaml"
    path.write_text(DRAFT)
    return load_model(path)


@pytest.mark.slow
@pytest.mark.parametrize("size", [1.0, 0.05, 40.0], ids=["1 N m", "a watch's", "a robot's"])
def test_stiffness_and_friction_by_load_are_found(draft, size):
    """Whatever its size: a watch's transmission and a robot's wind up alike."""
    recording = wound_up(2.0 * size, 0.05 * size, 0.08, viscous=2e-3 * size, noise=2e-3 * size)
    found = discover([recording], draft)
    assert found.verdict == "explained"
    assert {"spring_load", "mesh_friction"} == set(found.added)
    assert found.parameters["spring_load"]["stiffness"]["value"] == pytest.approx(2.0 * size, rel=0.01)
    assert found.parameters["mesh_friction"]["coefficient"]["value"] == pytest.approx(0.08, rel=0.05)


def test_friction_of_one_size_is_not_taken_for_one_by_load(draft):
    found = discover([wound_up(2.0, 0.05)], draft)
    assert set(found.added) == {"spring_load"}
    assert found.parameters["spring_load"]["stiffness"]["value"] == pytest.approx(2.0, rel=0.01)


@pytest.mark.slow
def test_play_is_said_to_be_unknown_over_the_position_and_no_wave(draft):
    """A free way of the spring is in no effect of the catalogue; waves over a part of a turn would fit it as well."""
    found = discover([wound_up(2.0, 0.05, gap=0.15)], draft)
    assert found.verdict == "unknown"
    assert set(found.added) <= {"spring_load"}
    assert "output_position" in found.depends_on


def test_an_output_that_stands_still_is_told_and_left_out(draft):
    recording = wound_up(2.0, 0.05)
    (warning,) = compare([recording], draft).warnings
    assert "the output stands still while the motor turns by 1 rad" in warning and "spring_load" in warning
    assert not any("output_position" in row.signals for row in compare([recording], draft).recordings)

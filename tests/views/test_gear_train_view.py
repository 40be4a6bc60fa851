"""The gear train that turns in rerun: its teeth stand in gaps, its wheels turn as the train's do, torques balance."""

import math

import numpy as np
import pytest

from ema_twin_sim.plant.planetary.geometry import OUTPUT_MESH, RING_MESH, SUN_MESH, Gearing
from ema_twin_sim.simulation.simulate import simulate
from ema_twin_sim.views.gear_train import starting_angles
from ema_twin_sim.views.train_motion import by_ratios, gearing_shown, train_motion
from ema_twin_sim.views.wheel_mesh import half_thickness, outline, wheel_meshes
from tests.recorded import record
from tests.run_train import planetary_model

OVERLAP = 2e-4  # m: facets stand for curved flanks


def solid(mesh, first):
    """Teeth, base radius, root, tip and kind of a mesh's first or second wheel."""
    teeth, base = (mesh.first_teeth, mesh.first_base_radius) if first else (mesh.second_teeth, mesh.second_base_radius)
    inner = mesh.internal and not first
    side, pitch = -1.0 if inner else 1.0, base / math.cos(mesh.pressure_angle)
    return teeth, base, pitch - side * 1.25 * mesh.addendum, pitch + side * mesh.addendum, inner


def deepest(points, wheel, angle):
    """How far [m] points (n, 2) reach into a wheel about the origin that is turned by an angle [rad]."""
    teeth, base, _, tip, inner = wheel
    radius = np.hypot(*points.T)
    place = np.mod((np.arctan2(points[:, 1], points[:, 0]) - angle) * teeth / (2.0 * math.pi) + 0.5, 1.0) - 0.5
    beside = np.abs(place) * 2.0 * math.pi / teeth - half_thickness(radius, teeth, base, PRESSURE, inner=inner)
    among_teeth = radius > tip if inner else radius < tip
    return float(np.max(np.where(among_teeth, -beside * radius, 0.0)))


PRESSURE = Gearing().pressure_angle


@pytest.mark.parametrize("sun", [0.0, 0.1, 1.7, 20.0])
def test_teeth_stand_in_gaps(sun):
    gearing = Gearing()
    motion = by_ratios(gearing, np.zeros(1), np.array([sun]), np.zeros(1))
    sun_at, planets, seconds, ring_at, output_at = starting_angles(gearing)
    kinds = gearing.meshes
    wheels = (
        (kinds[SUN_MESH], planets, sun_at + motion.sun[0], True),
        (kinds[RING_MESH], planets, ring_at, False),
        (kinds[OUTPUT_MESH], seconds, output_at + motion.output[0], False),
    )
    for mesh, starts, angle, of_sun in wheels:
        other = solid(mesh, of_sun)
        teeth, base, root, tip, _ = solid(mesh, not of_sun)
        toothing = outline(teeth, base, mesh.pressure_angle, root, tip, inner=False)
        for k, start in enumerate(starts):
            turned = start + motion.planets[0, k]
            way = motion.carrier[0] + 2.0 * math.pi * k / 3
            turn = np.array([[math.cos(turned), -math.sin(turned)], [math.sin(turned), math.cos(turned)]])
            points = toothing @ turn.T + gearing.centre_distance * np.array([math.cos(way), math.sin(way)])
            assert deepest(points, other, angle) < OVERLAP
            half_a_tooth = math.pi / other[0]
            assert deepest(points, other, angle + half_a_tooth) > 5.0 * OVERLAP  # else the test would see nothing


def test_meshes_have_the_teeth_and_the_width_of_the_gearbox():
    gearing = Gearing()
    for name, teeth in (("sun", 21), ("planet", 21), ("fixed_ring", 63), ("second_planet", 20), ("output_ring", 62)):
        mesh = wheel_meshes(gearing)[name]
        radius = np.hypot(mesh.positions[:, 0], mesh.positions[:, 1])
        reach = radius.min() if "ring" in name else radius.max()
        tips = np.isclose(radius, reach) & (mesh.positions[:, 2] > 0.0) & (mesh.normals[:, 2] > 0.5)
        assert tips.sum() == 2 * teeth  # two corners of each
        assert np.ptp(mesh.positions[:, 2]) == pytest.approx(gearing.face_width)
        assert np.linalg.norm(mesh.normals, axis=1) == pytest.approx(np.ones(len(mesh.normals)))
        assert mesh.triangles.max() == len(mesh.positions) - 1


def test_a_lumped_twin_turns_by_the_ratios(stock):
    (run,) = record(stock, ("ramp:0.05",), seconds=2.0)
    motion = train_motion(stock, gearing_shown(stock), run)
    assert not motion.simulated and len(motion.time) == 101  # 50 a second
    assert motion.output * 124.0 == pytest.approx(motion.sun) and motion.carrier * 4.0 == pytest.approx(motion.sun)
    assert motion.planets[:, 1] == pytest.approx(-0.5 * motion.sun)
    assert motion.sun == pytest.approx(run.signals["motor_position"][::10])
    on_sun, _, on_output = motion.torques
    assert motion.torques.sum(axis=0) == pytest.approx(np.zeros(101), abs=1e-9)
    assert on_output == pytest.approx(-124.0 * on_sun)
    assert on_sun == pytest.approx(-1.91 * run.signals["current"][::10])


def test_a_planetary_twin_turns_as_it_is_simulated(stock, tmp_path):
    (run,) = record(stock, ("sine:0.02:1",), seconds=1.0)
    model = planetary_model(tmp_path)
    motion = train_motion(model, gearing_shown(model), run)
    twin = simulate(model, run)
    assert motion.simulated
    # the counter that tells the position is quantised and noisy
    assert motion.sun == pytest.approx(twin.signals["motor_position"][::10], abs=2e-3)
    assert motion.output == pytest.approx(motion.sun / 124.0, abs=1e-3)
    on_output = motion.torques[2]
    assert (
        np.abs(motion.torques.sum(axis=0)).max() < 0.5 * np.abs(on_output).max()
    )  # what is left speeds up the carrier, and rubs


def test_only_a_gearbox_that_is_known_is_drawn(stock):
    assert gearing_shown(stock).ring_teeth == 63
    assert gearing_shown(stock.with_value("machine.gear_ratio", 100.0)) is None

"""Stiffness of teeth and meshes, the table of a mesh cycle, and how the train swings on it."""

import math

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_twin_sim.plant.planetary.displacements import rigid_motion, stiffness_matrix
from ema_twin_sim.plant.planetary.geometry import Gearing
from ema_twin_sim.plant.planetary.inertia import (
    TrainInertia,
    default_inertia,
    equivalent_masses,
    inertia_matrix,
    natural_frequencies,
    reduced_inertia,
    shaft_damping,
    shaft_stiffness,
)
from ema_twin_sim.plant.planetary.mesh_table import POINTS, STIFFNESS_KINDS, mean_arms, mean_stiffness, mesh_table
from ema_twin_sim.plant.planetary.quasi_static import static_forces
from ema_twin_sim.plant.planetary.stiffness import (
    constant_stiffness,
    harmonics,
    pair_stiffness,
    printed_series,
    single_pair_stiffness,
    tooth_stiffness,
)
from ema_twin_sim.plant.planetary.torsional_stiffness import stiffness_over_positions, torsional_stiffness
from tests.fidelities import LONGEST

pytestmark = pytest.mark.timeout(LONGEST)

BENCH = Gearing()
TABLE = mesh_table(BENCH)
GEARBOX, MOTOR, OUTPUT = 1.75e-6, 7.7e-4, 1e-3


def test_tooth_stiffness_by_hand_and_in_the_range_of_steel_teeth():
    """Kuang and Yang of 21 teeth, added up by hand; ISO 6336-1 puts a pair at about 14 N/(mm um) of face width."""
    assert tooth_stiffness(21, 0.0) == pytest.approx(26.2977e9, rel=1e-4)
    assert tooth_stiffness(21, 0.5) == pytest.approx((26.2977 - 0.5 * 14.3398) * 1e9, rel=1e-4)
    at_pitch = pair_stiffness(BENCH, BENCH.meshes[0], np.array([BENCH.meshes[0].approach]))
    assert at_pitch[0] / BENCH.face_width == pytest.approx(13.15e9, rel=1e-3)
    assert tooth_stiffness(20, 0.2, 0.3) != tooth_stiffness(20, 0.2)
    assert tooth_stiffness(140, 0.3) == tooth_stiffness(100, 0.3)


@pytest.mark.parametrize("teeth", [12, 21, 63, 100])
def test_teeth_give_way_more_towards_their_tip_and_stay_stiff(teeth):
    stiffness = tooth_stiffness(teeth, np.linspace(-1.0, 1.0, 21))
    assert (np.diff(stiffness) < 0.0).all() and (stiffness > 0.0).all()


def test_a_pair_of_equal_wheels_is_as_stiff_before_the_pitch_point_as_after_it():
    mesh = BENCH.meshes[0]
    position = np.linspace(0.0, mesh.contact_length, 51)
    stiffness = pair_stiffness(BENCH, mesh, position)
    assert np.allclose(stiffness, stiffness[::-1], rtol=1e-12)


def test_stiffness_scales_with_face_width_and_modulus_once():
    wide = mesh_table(Gearing(face_width=0.036), youngs_modulus_ratio=0.01)
    assert np.allclose(wide[:, :, :2], 0.02 * TABLE[:, :, :2], rtol=1e-12)
    assert np.allclose(wide[:, :, 2:], TABLE[:, :, 2:], rtol=1e-12)


@pytest.mark.parametrize("kind", range(3))
def test_two_pairs_carry_for_contact_ratio_minus_one_and_the_mean_is_that_of_the_path(kind):
    mesh = BENCH.meshes[kind]
    two = TABLE[kind, 1:-1, 1] > 0.0
    assert two.mean() == pytest.approx(mesh.contact_ratio - 1.0, abs=1.5 / POINTS)
    position = np.linspace(0.0, mesh.contact_length, 20001)
    mean = np.trapezoid(pair_stiffness(BENCH, mesh, position), position) / mesh.base_pitch
    assert mean_stiffness(TABLE)[kind] == pytest.approx(mean, rel=1e-4)


@pytest.mark.parametrize("stiffness", STIFFNESS_KINDS)
def test_every_table_is_closed_and_has_the_same_arms(stiffness):
    table = mesh_table(BENCH, stiffness)
    assert table.shape == (3, POINTS + 1, 4) and table.dtype == np.float64
    assert np.array_equal(table[:, 0], table[:, -1])
    assert (table[:, :, 0] > 0.0).all() and (table[:, :, 1] >= 0.0).all()
    assert np.array_equal(table[:, :, 2:], TABLE[:, :, 2:])
    assert np.allclose(mean_stiffness(table), mean_stiffness(TABLE), rtol=0.02)


def test_friction_arms_never_let_friction_drive():
    """Sliding weighted by load has the sign of the motion all over the cycle."""
    for mesh, (arm_1, arm_2) in zip(BENCH.meshes, TABLE[:, :, 2:].transpose(0, 2, 1), strict=True):
        sliding = arm_1 / mesh.first_base_radius - arm_2 / mesh.second_base_radius
        assert (sliding >= -1e-16).all()


def test_mean_arms_are_those_of_the_path_shared_by_stiffness():
    for mesh, found in zip(BENCH.meshes, mean_arms(TABLE), strict=True):
        u = (np.arange(1000000) + 0.5) / 1000000
        position = np.stack([u, u + 1.0]) * mesh.base_pitch
        pairs = np.where(position < mesh.contact_length, pair_stiffness(BENCH, mesh, position), 0.0)
        share = pairs / pairs.sum(axis=0) * np.sign(position - mesh.approach)
        exact = [(share * arm).sum(axis=0).mean() for arm in mesh.curvature_radii(position)]
        assert found == pytest.approx(exact, abs=2e-6)  # m, of arms of 20 mm


def test_constant_form_is_the_printed_one():
    mesh = BENCH.meshes[0]
    expected = (0.75 * mesh.contact_ratio + 0.25) * single_pair_stiffness(BENCH, mesh)
    assert constant_stiffness(BENCH, mesh) == pytest.approx(expected, rel=1e-12)
    assert np.allclose(mesh_table(BENCH, "constant")[0, :, 0], expected, rtol=1e-12)


def test_printed_series_has_its_three_harmonics_and_no_other():
    amplitudes = np.abs(harmonics(printed_series(1.0, np.arange(64) / 64), 8)) * math.pi
    assert amplitudes == pytest.approx([1.0, 0.0, 1 / 3, 0.0, 1 / 5, 0.0, 0.0, 0.0], abs=1e-14)


def test_true_harmonics_rebuild_the_alternating_stiffness():
    values = TABLE[0, :-1, :2].sum(axis=1)
    amplitudes = harmonics(values, POINTS // 2 - 1)
    u = np.arange(POINTS) / POINTS
    rebuilt = values.mean() + sum((a * np.exp(2j * math.pi * k * u)).real for k, a in enumerate(amplitudes, start=1))
    assert np.abs(rebuilt - values).max() < 0.02 * values.mean()


def test_the_trains_stiffness_is_its_meshes_in_series_by_their_static_forces():
    """Energy: with constant meshes, 1/K = 3 sum of (F/T)^2/k; the rings' meshes give way most."""
    table = mesh_table(BENCH, "constant")
    fast, slow = torsional_stiffness(BENCH, table)
    forces = static_forces(BENCH, 1.0)
    assert fast == pytest.approx(1.0 / (3.0 * (forces**2 / mean_stiffness(table)).sum()), rel=1e-9)
    assert slow == pytest.approx(fast * 124.0**2, rel=1e-12)


def test_steel_gearbox_stiffness_and_how_far_it_swings():
    fast, _ = torsional_stiffness(BENCH, TABLE)
    along = stiffness_over_positions(BENCH, TABLE)
    assert fast == pytest.approx(312.0, rel=0.01)  # N m/rad
    assert along.min() < fast < along.max()


def test_default_inertias_add_up_to_the_gearboxs():
    parts = default_inertia(BENCH, GEARBOX)
    assert reduced_inertia(BENCH, parts) == pytest.approx(GEARBOX, rel=1e-14)
    assert min(parts.sun, parts.planet, parts.planet_mass) > 0.0


def test_reduced_inertia_is_the_kinetic_energy_of_rigid_motion():
    parts = TrainInertia(1e-6, 2e-6, 3e-3, 4e-6)
    motion = rigid_motion(BENCH)
    energy = motion @ inertia_matrix(BENCH, parts, MOTOR, OUTPUT) @ motion
    assert energy == pytest.approx(MOTOR + reduced_inertia(BENCH, parts) + OUTPUT, rel=1e-13)


def test_the_train_swings_as_two_inertias_on_its_stiffness_where_its_own_are_small():
    table = mesh_table(BENCH, "constant")
    parts = default_inertia(BENCH, 1e-9)
    frequencies = natural_frequencies(BENCH, table, parts, MOTOR, OUTPUT)
    fast, _ = torsional_stiffness(BENCH, table)
    assert frequencies[1] == pytest.approx(math.sqrt(fast * (1.0 / MOTOR + 1.0 / OUTPUT)), rel=1e-4)
    assert frequencies[0] < 1.0


def test_steel_teeth_on_the_benchs_inertias_exceed_a_million_radians_a_second():
    parts = default_inertia(BENCH, GEARBOX)
    steel = natural_frequencies(BENCH, TABLE, parts, MOTOR, OUTPUT)
    printed = natural_frequencies(BENCH, mesh_table(BENCH, youngs_modulus_ratio=0.01), parts, MOTOR, OUTPUT)
    assert steel[-1] == pytest.approx(1.66e6, rel=0.01)
    assert printed[-1] == pytest.approx(0.1 * steel[-1], rel=1e-9)


def test_free_rotation_costs_no_force():
    matrix = stiffness_matrix(BENCH, np.full((3, 3), 1e8))
    assert np.allclose(matrix @ rigid_motion(BENCH), 0.0, atol=1e-8)
    assert np.allclose(matrix, matrix.T)


def test_equivalent_mass_of_equal_wheels_is_half_of_one():
    parts = TrainInertia(2e-6, 2e-6, 1e-3, 0.0)
    sun, ring, _ = equivalent_masses(BENCH, parts, 0.0)
    assert sun == pytest.approx(0.5 * ring, rel=1e-12)
    assert ring == pytest.approx(2e-6 / 0.035**2, rel=1e-12)


def test_shaft_of_the_script():
    """8 mm by 40 mm of steel: the script has 697 N m/rad by taking 0.33 E for the shear modulus."""
    assert shaft_stiffness(0.004, 0.04, 0.33 * 210e9) == pytest.approx(697.0, rel=1e-3)
    damping = shaft_damping(697.0, 2e-6, 0.1)
    assert damping == pytest.approx(0.1 * 2.0 * math.sqrt(697.0 * 2e-6), rel=1e-12)


@pytest.mark.parametrize(
    ("kind", "ratio", "said"), [("linear", 1.0, "choose alternating"), ("constant", 0.0, "youngs")]
)
def test_a_table_of_nothing_known_is_refused(kind, ratio, said):
    with pytest.raises(InputError, match=said):
        mesh_table(BENCH, kind, ratio)

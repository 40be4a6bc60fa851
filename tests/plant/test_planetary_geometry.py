"""The wheels of the planetary gearbox: they mesh, they can be assembled, and what does not is refused in one line."""

import math

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_twin_sim.plant.planetary.displacements import displacements, rigid_motion
from ema_twin_sim.plant.planetary.geometry import Gearing
from ema_twin_sim.plant.planetary.phases import mesh_cycles, mesh_phases, opposite_flank, sun_to_ring

BENCH = Gearing()
BACKWARDS = Gearing(second_planet_teeth=22, output_ring_teeth=64)  # its output turns against the sun
GEARINGS = (BENCH, BACKWARDS, Gearing(second_planet_teeth=19, output_ring_teeth=61))


def test_the_ratio_is_124_exactly_and_follows_from_rolling_without_deformation():
    assert BENCH.ratio == 124.0
    assert BENCH.carrier_ratio == 0.25 and BENCH.planet_ratio == 0.75
    for gearing in GEARINGS:
        assert np.allclose(displacements(gearing) @ rigid_motion(gearing), 0.0, atol=1e-16)
    assert BACKWARDS.ratio == -128.0


def test_all_meshes_have_one_centre_distance_and_one_base_pitch():
    sun, ring, output = BENCH.meshes
    assert sun.centre_distance == pytest.approx(75.767e-3, abs=1e-6)
    assert ring.centre_distance == pytest.approx(sun.centre_distance, rel=1e-14)
    assert output.centre_distance == pytest.approx(sun.centre_distance, rel=1e-14)
    assert {round(mesh.base_pitch, 15) for mesh in BENCH.meshes} == {round(BENCH.base_pitch, 15)}
    assert BENCH.module == pytest.approx(3.608e-3, abs=1e-6)
    assert BENCH.addendum == pytest.approx(2.716e-3, abs=1e-6)


def test_base_radii_follow_the_teeth():
    radii = [BENCH.planet_radius, BENCH.ring_radius, BENCH.second_planet_radius, BENCH.output_ring_radius]
    assert radii == pytest.approx([0.035, 0.105, 0.1 / 3.0, 0.31 / 3.0], rel=1e-14)


def test_contact_ratios():
    assert [mesh.contact_ratio for mesh in BENCH.meshes] == pytest.approx([1.1609, 1.3151, 1.3129], abs=1e-4)


@pytest.mark.parametrize("gearing", GEARINGS)
@pytest.mark.parametrize("kind", range(3))
def test_contact_runs_from_one_tip_to_the_other_through_the_pitch_point(gearing, kind):
    """The contact's distances from both axes are the tip radii at its ends and the pitch radii between."""
    mesh = gearing.meshes[kind]
    first, second = mesh.curvature_radii(np.array([0.0, mesh.approach, mesh.contact_length]))
    on_first, on_second = np.hypot(first, mesh.first_base_radius), np.hypot(second, mesh.second_base_radius)
    assert on_second[0] == pytest.approx(mesh.second_tip_radius, rel=1e-12)
    assert on_first[1] == pytest.approx(mesh.first_pitch_radius, rel=1e-12)
    assert on_second[1] == pytest.approx(mesh.second_pitch_radius, rel=1e-12)
    assert on_first[2] == pytest.approx(mesh.first_tip_radius, rel=1e-12)
    angles = np.array(mesh.contact_angles)
    assert np.allclose(mesh.first_base_radius * np.tan(angles), first[[0, 2]], rtol=1e-12)


@pytest.mark.parametrize("kind", range(3))
def test_the_flanks_do_not_slide_at_the_pitch_point_and_turn_their_sliding_there(kind):
    mesh = BENCH.meshes[kind]
    position = np.array([0.2, 1.0, 1.5]) * mesh.approach
    first, second = mesh.curvature_radii(position)
    sliding = first / mesh.first_base_radius - second / mesh.second_base_radius  # speed over base circles' speed
    assert sliding[0] < 0.0 and sliding[1] == pytest.approx(0.0, abs=1e-14) and sliding[2] > 0.0


def test_sun_and_ring_meshes_are_in_phase_and_those_of_the_output_a_third_apart():
    """So order 15.75 of the planets' sun and ring meshes adds, and order 15.0 of their output meshes cancels."""
    sun, ring, output = np.exp(2j * math.pi * mesh_phases(BENCH))
    assert abs(sun.sum()) == pytest.approx(3.0, rel=1e-14)
    assert abs(ring.sum()) == pytest.approx(3.0, rel=1e-14)
    assert abs(output.sum()) == pytest.approx(0.0, abs=1e-14)
    assert abs((output**3).sum()) == pytest.approx(3.0, rel=1e-14)  # order 45 remains
    assert sorted(mesh_phases(BENCH)[2]) == pytest.approx([0.0, 1 / 3, 2 / 3], rel=1e-14)


def test_mesh_orders_are_15_75_and_15_and_the_slowest_ramps_mesh_takes_a_third_of_a_second():
    turn = 2.0 * math.pi
    motion = rigid_motion(BENCH)
    cycles = mesh_cycles(BENCH, turn, turn * motion[4], turn * motion[5]) - mesh_phases(BENCH)
    assert np.allclose(cycles, np.array([15.75, 15.75, 15.0])[:, np.newaxis], rtol=1e-13)
    assert turn / (0.01 * 124.0) / 15.75 == pytest.approx(0.3, abs=0.03)  # thesis, section 3.9


def test_sun_and_ring_meshes_of_an_odd_planet_pass_their_pitch_points_together():
    sun, ring, _ = BENCH.meshes
    at_pitch = sun.approach / sun.base_pitch
    assert (at_pitch + sun_to_ring(BENCH)) % 1.0 == pytest.approx(ring.approach / ring.base_pitch, rel=1e-12)
    even = Gearing(planet_teeth=24, ring_teeth=69, second_planet_teeth=23, output_ring_teeth=68)
    sun, ring, _ = even.meshes
    off = (sun.approach / sun.base_pitch + sun_to_ring(even) - ring.approach / ring.base_pitch) % 1.0
    assert off == pytest.approx(0.5, abs=1e-12)


def test_opposite_flanks_are_half_a_cycle_from_the_pitch_point_when_the_others_pass_it():
    for mesh, turned in zip(BENCH.meshes, opposite_flank(BENCH), strict=True):
        at_pitch = mesh.approach / mesh.base_pitch
        assert (turned - at_pitch - at_pitch) % 1.0 == pytest.approx(0.5, abs=1e-12)


@pytest.mark.parametrize(
    ("numbers", "said"),
    [
        ({"ring_teeth": 64}, "planet and fixed ring is 77.571 mm, 1.804 mm more .* ring_teeth: 63 would fit"),
        ({"output_ring_teeth": 61}, "output ring is 73.963 mm, 1.804 mm less .* output_ring_teeth: 62 would fit"),
        ({"second_planet_teeth": 21, "output_ring_teeth": 63}, "ratio is infinite: 63 x 21 equals 63 x 21"),
        (
            {"planet_teeth": 20, "ring_teeth": 61, "second_planet_teeth": 19, "output_ring_teeth": 60},
            "82 teeth together, which 3 does not divide",
        ),
        (
            {
                "sun_teeth": 12,
                "planet_teeth": 81,
                "ring_teeth": 174,
                "second_planet_teeth": 80,
                "output_ring_teeth": 173,
                "tip_radius": 0.0425,
            },
            "neighbouring planets overlap",
        ),
        ({"tip_radius": 0.0385}, "sun and planet have a contact ratio of 0.294"),
        ({"tip_radius": 0.0425}, "planet and fixed ring have a contact ratio of 2.265"),
        ({"pressure_angle": math.radians(15.0)}, "sun and planet interfere: contact would go 1.* mm beyond"),
        ({"tip_radius": 0.047, "pressure_angle": math.radians(25.0)}, "inside its base circle|interfere|contact ratio"),
        ({"tip_radius": 0.037}, "37 mm is not above the sun's pitch radius of 37.884 mm"),
        ({"sun_teeth": 21.5}, "sun_teeth is 21.5: give a whole number"),
        ({"planet_teeth": -21}, "planet_teeth is -21: give a whole number of at least 12"),
        ({"face_width": 0.0}, "face_width is 0.0 m"),
        ({"face_width": math.nan}, "face_width is nan m"),
        ({"pressure_angle": 22.5}, "pressure_angle is 22.5 rad"),
        ({"profile_shift": -1.0}, "profile_shift is -1.0"),
    ],
)
def test_wheels_that_do_not_work_are_refused_in_one_line(numbers, said):
    with pytest.raises(InputError, match=said) as refused:
        Gearing(**numbers, place="model.yaml: transmission")
    assert str(refused.value).startswith("model.yaml: transmission: ")
    assert "\n" not in str(refused.value)


def test_without_a_place_the_refusal_names_none():
    with pytest.raises(InputError, match=r"^the centre distance"):
        Gearing(ring_teeth=64)

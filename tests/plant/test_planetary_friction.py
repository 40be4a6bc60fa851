"""Coefficients of friction of the teeth, by the standards and at their limits."""

import numpy as np
import pytest

from ema_twin_sim.plant.planetary.friction_coefficient import (
    BOUNDARY_LUBRICATION,
    CONSTANT,
    FRICTION_LAWS,
    ISO_TR_14179_2,
    ISO_TS_6336_4,
    dynamic_viscosity,
    friction_coefficient,
)

STEEL = {"line_load": 150e3, "sum_speed": 5.0, "curvature_radius": 0.01, "viscosity": 0.02, "roughness": 0.8e-6}
STANDARDS = (ISO_TR_14179_2, ISO_TS_6336_4)


def coefficient(law, constant=0.0, **changes):
    return friction_coefficient(law, constant, *{**STEEL, **changes}.values())


def test_the_standards_by_hand():
    """150 N/mm, 5 m/s, 10 mm, 20 mPa s, 0.8 um."""
    assert coefficient(ISO_TR_14179_2) == pytest.approx(0.048 * 3.0**0.2 * 20.0**-0.05 * 0.8**0.25, rel=1e-12)
    assert coefficient(ISO_TS_6336_4) == pytest.approx(0.143 * (0.8 * 150.0 / (5.0 * 10.0 * 20.0)) ** 0.25, rel=1e-12)


@pytest.mark.parametrize("law", STANDARDS)
def test_oiled_steel_wheels_are_where_the_standards_have_them(law):
    assert 0.03 < coefficient(law) < 0.1


def test_the_benchs_ring_mesh_has_about_what_the_design_expects_and_not_the_scripts_0_005():
    bench = {"line_load": 2200.0, "sum_speed": 0.027, "curvature_radius": 0.0217, "roughness": 1e-7}
    assert coefficient(ISO_TR_14179_2, **bench, viscosity=dynamic_viscosity(293.15)) == pytest.approx(0.035, abs=0.01)


@pytest.mark.parametrize("law", STANDARDS)
def test_friction_falls_with_speed_and_rises_with_load_and_roughness(law):
    assert coefficient(law, sum_speed=10.0) < coefficient(law) < coefficient(law, sum_speed=1.0)
    assert coefficient(law, line_load=1e5) < coefficient(law) < coefficient(law, line_load=3e5)
    assert coefficient(law, roughness=4e-7) < coefficient(law) < coefficient(law, roughness=2e-6)
    assert coefficient(law, viscosity=0.1) < coefficient(law)


@pytest.mark.parametrize("law", STANDARDS)
def test_towards_standstill_friction_grows_to_its_bound_without_a_jump(law):
    speeds = np.geomspace(1e-12, 1.0, 400)
    found = np.array([coefficient(law, sum_speed=speed) for speed in speeds])
    assert (np.diff(found) <= 0.0).all() and found.max() == BOUNDARY_LUBRICATION
    assert np.abs(np.diff(found)).max() < 0.01
    assert coefficient(law, sum_speed=0.0) == BOUNDARY_LUBRICATION


@pytest.mark.parametrize("law", STANDARDS)
@pytest.mark.parametrize("speed", [0.0, 1.0])
def test_without_a_load_there_is_no_friction_and_no_nan(law, speed):
    assert coefficient(law, line_load=0.0, sum_speed=speed) == 0.0


def test_a_constant_is_itself_at_any_load_and_speed():
    assert coefficient(CONSTANT, 0.11) == 0.11
    assert coefficient(CONSTANT, 0.11, sum_speed=0.0, line_load=0.0) == 0.11
    assert [FRICTION_LAWS.index(name) for name in FRICTION_LAWS] == [CONSTANT, *STANDARDS]


def test_viscosity_is_the_scripts_and_falls_with_temperature():
    kinematic = 10.0 ** (10.0 ** (-1.890758 * np.log(293.15) + 10.5253))
    density = 0.869 * np.exp(-0.001 * (20.0 - 15.0))
    assert dynamic_viscosity(293.15) == pytest.approx(kinematic / 1e6 * density * 1000.0, rel=1e-12)
    assert dynamic_viscosity(313.15) < dynamic_viscosity(293.15) < dynamic_viscosity(273.15)

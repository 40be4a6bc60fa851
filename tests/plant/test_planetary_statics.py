"""The planetary train in slow steady motion: forces, power, efficiency both ways, self-locking."""

import numpy as np
import pytest

from ema_twin_sim.plant.planetary.friction_coefficient import ISO_TR_14179_2, ISO_TS_6336_4, dynamic_viscosity
from ema_twin_sim.plant.planetary.geometry import Gearing
from ema_twin_sim.plant.planetary.mesh_table import mean_arms, mesh_table
from ema_twin_sim.plant.planetary.quasi_static import (
    ToothFriction,
    balance,
    efficiencies,
    self_locking_coefficient,
    sliding_speeds,
    static_forces,
    sum_speeds,
)

BENCH = Gearing()
BACKWARDS = Gearing(second_planet_teeth=22, output_ring_teeth=64)  # its output turns against the sun
TABLES = {gearing: mesh_table(gearing) for gearing in (BENCH, BACKWARDS)}
OIL = dynamic_viscosity(293.15)


def efficiency(coefficient, output_drives=False, gearing=BENCH):
    friction = ToothFriction(constant=coefficient)
    return balance(gearing, TABLES[gearing], friction, 1.0, 1.0, output_drives).efficiency


def test_static_forces_are_1_to_41_to_minus_42():
    assert static_forces(BENCH, 1.0) * 3.0 * 0.035 == pytest.approx([1.0, 41.0, -42.0], rel=1e-12)


@pytest.mark.parametrize("gearing", TABLES)
@pytest.mark.parametrize("output_drives", [False, True])
@pytest.mark.parametrize("coefficient", [0.0, 0.01, 0.1, 0.25, 0.5])
def test_power_balances_and_all_wheels_are_in_balance(gearing, output_drives, coefficient):
    found = balance(gearing, TABLES[gearing], ToothFriction(constant=coefficient), 2.0, 3.0, output_drives)
    taken = max(abs(found.sun_power), abs(found.output_power))
    assert found.sun_power - found.output_power == pytest.approx(found.losses.sum(), abs=1e-12 * taken)
    assert (found.losses >= 0.0).all()
    driven = -np.sign(gearing.ratio) * found.output_torque if output_drives else found.sun_torque
    assert driven == pytest.approx(2.0, rel=1e-12)


@pytest.mark.parametrize("gearing", TABLES)
@pytest.mark.parametrize("law", [ISO_TR_14179_2, ISO_TS_6336_4])
@pytest.mark.parametrize("output_drives", [False, True])
def test_power_balances_with_the_standards_too(gearing, law, output_drives):
    friction = ToothFriction(law, 0.0, OIL, 1e-6)
    found = balance(gearing, TABLES[gearing], friction, 5.0, 1.24, output_drives)
    taken = max(abs(found.sun_power), abs(found.output_power))
    assert found.sun_power - found.output_power == pytest.approx(found.losses.sum(), abs=1e-12 * taken)
    again = friction.coefficients(gearing, found.forces, 1.24)
    assert found.coefficients == pytest.approx(again, rel=1e-12)


@pytest.mark.parametrize("gearing", TABLES)
@pytest.mark.parametrize("output_drives", [False, True])
def test_without_friction_nothing_is_lost(gearing, output_drives):
    assert efficiency(0.0, output_drives, gearing) == pytest.approx(1.0, abs=1e-13)
    assert not balance(gearing, TABLES[gearing], ToothFriction(), 1.0).loss_shares.any()


def test_efficiency_both_ways_and_where_it_is_lost():
    """At 0.1, load shared by the pairs' stiffness: 0.73 forwards, 0.64 backwards, 96 % of it in the two ring meshes."""
    assert efficiency(0.1) == pytest.approx(0.7326, abs=1e-3)
    assert efficiency(0.1, True) == pytest.approx(0.6420, abs=1e-3)
    forwards = balance(BENCH, TABLES[BENCH], ToothFriction(constant=0.1), 1.0)
    assert forwards.loss_shares[1:].sum() == pytest.approx(0.957, abs=2e-3)


def test_efficiency_falls_with_friction_and_backwards_faster():
    forwards = [efficiency(mu) for mu in np.linspace(0.0, 0.5, 11)]
    backwards = [efficiency(mu, True) for mu in np.linspace(0.0, 0.5, 11)]
    assert (np.diff(forwards) < 0.0).all() and (np.diff(backwards) < 0.0).all()
    assert (np.array(backwards[1:]) < forwards[1:]).all()
    assert min(forwards) > 0.0


@pytest.mark.parametrize("gearing", TABLES)
def test_self_locking_begins_where_backward_efficiency_ends(gearing):
    locking = self_locking_coefficient(gearing, TABLES[gearing])
    assert locking == pytest.approx(0.2845, abs=1e-3)
    assert efficiency(locking, True, gearing) == pytest.approx(0.0, abs=1e-10)
    assert efficiency(locking - 1e-6, True, gearing) > 0.0 > efficiency(locking + 1e-6, True, gearing)


def test_a_short_way_losses_are_friction_times_frictionless_force_times_sliding():
    """To first order in the coefficient, the loss needs no balance: mu 3 sum of F V at the static forces."""
    mu = 1e-6
    loss = 3.0 * mu * np.abs(static_forces(BENCH, 1.0)) @ sliding_speeds(BENCH, mean_arms(TABLES[BENCH]), 1.0)
    assert 1.0 - efficiency(mu) == pytest.approx(loss, rel=1e-4)
    assert 1.0 - efficiency(mu, True) == pytest.approx(loss, rel=1e-4)


def test_efficiency_by_the_standards_rises_with_speed_and_falls_with_load():
    torques, speeds = np.array([0.1, 1.0, 5.0]), np.array([1.24, 12.4, 124.0])
    for law in (ISO_TR_14179_2, ISO_TS_6336_4):
        found = efficiencies(BENCH, TABLES[BENCH], ToothFriction(law, 0.0, OIL, 1e-7), torques, speeds)
        assert found.shape == (3, 3)
        assert (np.diff(found, axis=1) > 0.0).all() and (np.diff(found, axis=0) < 0.0).all()
        assert (found > 0.5).all() and (found < 1.0).all()


def test_rolling_speeds_at_the_pitch_point():
    """Sun's mesh: both flanks roll at (w_s - w_c) r_s tan a; the planets' two toothings at theirs."""
    found = sum_speeds(BENCH, -2.0)
    tangent = np.tan(BENCH.pressure_angle)
    assert found[0] == pytest.approx(2.0 * 2.0 * 0.75 * 0.035 * tangent, rel=1e-12)
    assert found[1] == pytest.approx(found[0], rel=1e-12)
    assert found[2] == pytest.approx(found[0] * 20.0 / 21.0, rel=1e-12)

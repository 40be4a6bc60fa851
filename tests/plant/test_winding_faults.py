"""Faults of the winding and the rotor against the torque that theory gives under imposed currents.

The comparators impose the currents: sinusoidal ones of amplitude I in phase with the healthy shapes, whatever the motor
has. With x = P theta the healthy torque is T0 = Ke I sum sin^2(x - 2 pi k / 3) = 1.5 Ke I, k = 0, 1, 2 for u, v, w.
"""

import cmath
import math

import numpy as np
import pytest

from tests.turned_motor import POLITECNICO, STEP, currents, order, turn, turns, winding

SETPOINT = 4.0
SPEED = 20.0  # rad/s: back-EMF well below the link, so that currents stay imposed
HEALTHY = POLITECNICO["torque_constant"] * SETPOINT
PAIRS = POLITECNICO["pole_pairs"]
PHASES = {"u": 0, "v": 1, "w": 2}


def run_with(**faults):
    return turns(winding(hysteresis=0.02, **faults), 2, SETPOINT, SPEED, settle=0.02)


@pytest.mark.parametrize("phase", PHASES)
@pytest.mark.parametrize("short", [0.05, 0.3])
def test_a_short_takes_a_third_of_its_share_and_ripples_at_twice_the_pole_pairs(phase, short):
    """Phase k makes Ke I sin^2(x - 2 pi k / 3) = Ke I (1 - cos(2 x - 4 pi k / 3)) / 2, of which the share f is lost:

    T / T0 = 1 - f / 3 + f / 3 cos(2 P theta - 4 pi k / 3), order 8 with four pole pairs. The drive does not see it: its
    quadrature current is the setpoint.
    """
    run = run_with(**{f"active_turns_{phase}": 1.0 - short})
    assert run["torque"].mean() / HEALTHY == pytest.approx(1.0 - short / 3.0, abs=0.004)
    expected = short / 3.0 * cmath.exp(-4j * math.pi / 3.0 * PHASES[phase])
    assert abs(order(run, "torque", 2.0 * PAIRS) / HEALTHY - expected) < 0.02 * short / 3.0 + 3e-4
    assert run["quadrature_current"].mean() == pytest.approx(SETPOINT, rel=0.004)


def test_shorts_in_all_phases_alike_leave_no_ripple():
    run = run_with(active_turns_u=0.8, active_turns_v=0.8, active_turns_w=0.8)
    assert run["torque"].mean() / HEALTHY == pytest.approx(0.8, abs=0.004)
    assert abs(order(run, "torque", 2.0 * PAIRS)) / HEALTHY < 1e-3


def test_a_short_costs_block_commutation_a_third_of_its_share_too():
    """Each phase carries the current, on its flat, for two thirds of the time: a third of the torque is its own."""
    run = turns(winding(hysteresis=0.02, trapezoidal=1.0, active_turns_v=0.7), 2, SETPOINT, 5.0, settle=0.02)
    assert run["torque"].mean() / HEALTHY == pytest.approx(0.9, abs=0.005)


@pytest.mark.parametrize("shorted", [1.0, 0.6])
def test_a_shorted_phase_has_its_share_of_resistance_and_the_square_of_inductance(shorted):
    """Locked rotor, u on the upper rail in series with v and w side by side: R = N R + R / 2, L = N^2 L + L / 2."""
    run = turn(winding(active_turns_u=shorted), 0.02, setpoint=1e6, speed=0.0, angle=0.5 * math.pi / PAIRS)
    switch = POLITECNICO["switch_resistance"]
    resistance = (shorted + 0.5) * POLITECNICO["phase_resistance"] + 1.5 * switch
    inductance = (shorted**2 + 0.5) * POLITECNICO["phase_inductance"]
    time = STEP * np.arange(1, 20001)
    expected = POLITECNICO["dc_link_voltage"] / resistance * -np.expm1(-time * resistance / inductance)
    np.testing.assert_allclose(run["phase_current_u"], expected, rtol=1e-8)


@pytest.mark.parametrize("phase", [0.0, 1.1])
@pytest.mark.parametrize("eccentricity", [0.1, 0.4])
def test_eccentricity_ripples_at_twice_the_pole_pairs_and_one(eccentricity, phase):
    """Phase k's back-EMF times 1 + zeta cos(theta + phi - 2 pi k / 3), its torque (1 - cos(2 x - 4 pi k / 3)) / 2.

    The constant half sums three cosines a third of a turn apart: nothing at order 1, and the mean stays. The other half
    has the products cos(2 x - 4 pi k / 3) cos(theta + phi - 2 pi k / 3): at order 2 P + 1 their phases are 6 pi k / 3,
    all alike, and add up; at 2 P - 1 they are 2 pi k / 3, and cancel. So T / T0 = 1 - zeta / 2 cos(9 theta + phi).
    """
    run = run_with(eccentricity=eccentricity, eccentricity_phase=phase)
    assert run["torque"].mean() / HEALTHY == pytest.approx(1.0, abs=0.004)
    ripple = order(run, "torque", 2.0 * PAIRS + 1.0) / HEALTHY
    assert abs(ripple + 0.5 * eccentricity * cmath.exp(1j * phase)) < 0.02 * 0.5 * eccentricity
    for silent in (1.0, 2.0 * PAIRS - 1.0, 2.0 * PAIRS):
        assert abs(order(run, "torque", silent)) / HEALTHY < 1.5e-3


def test_eccentricity_under_block_commutation_adds_an_order_of_four_times_the_pole_pairs_less_one():
    """Phase k carries for two 120 deg blocks a turn: 2/3 + a2 cos(2 x) + a4 cos(4 x) + …, shifted by 2 pi k / 3.

    a2 = -sqrt(3) / pi, a4 = -sqrt(3) / (2 pi). Times the cosines of eccentricity, the second harmonic adds up at order
    2 P + 1 as before, the fourth at 4 P - 1: of the torque 2 Ke I, 3 a2 zeta / 4 and 3 a4 zeta / 4.
    """
    run = turns(
        winding(hysteresis=0.02, trapezoidal=1.0, eccentricity=0.2, eccentricity_phase=0.7),
        1,
        SETPOINT,
        5.0,
        settle=0.02,
    )
    second, fourth = (-0.75 * 0.2 * math.sqrt(3.0) / (part * math.pi) for part in (1.0, 2.0))
    assert abs(order(run, "torque", 9.0) / HEALTHY - second * cmath.exp(0.7j)) < 0.05 * abs(second)
    assert abs(order(run, "torque", 15.0) / HEALTHY - fourth * cmath.exp(-0.7j)) < 0.05 * abs(fourth)


def test_weak_magnets_cost_torque_that_the_drive_does_not_see():
    run = run_with(magnet_strength=0.85)
    assert run["torque"].mean() / HEALTHY == pytest.approx(0.85, abs=0.004)
    assert run["quadrature_current"].mean() == pytest.approx(SETPOINT, rel=0.004)


def test_faults_leave_the_imposed_currents_sinusoidal():
    run = run_with(active_turns_u=0.7, eccentricity=0.3)
    amplitude = SETPOINT * POLITECNICO["torque_constant"] / (1.5 * POLITECNICO["back_emf_constant"])
    reference = amplitude * np.sin(PAIRS * run["angle"][:, None] - 2.0 * math.pi / 3.0 * np.arange(3))
    assert np.abs(currents(run) - reference).max() < 0.12

"""The switching drive's electrical side against closed forms: winding, comparators, torque, energy, acquisition."""

import math

import numpy as np
import pytest
from scipy.special import jv

from ema_twin_sim.plant.switching.dc_link import highest_speed, voltage_needed
from ema_twin_sim.plant.switching.electrical_angle import sine_and_cosine, turned
from ema_twin_sim.plant.switching.layout import resting
from ema_twin_sim.plant.switching.shapes import three_trapezoids, trapezoid
from tests.turned_motor import POLITECNICO, STEP, currents, order, turn, turns, winding

SHAPES = pytest.mark.parametrize("trapezoidal", [0.0, 1.0], ids=["sinusoidal", "trapezoidal"])
KT, KE, PAIRS = (POLITECNICO[name] for name in ("torque_constant", "back_emf_constant", "pole_pairs"))
RESISTANCE = POLITECNICO["phase_resistance"] + POLITECNICO["switch_resistance"]
INDUCTANCE = POLITECNICO["phase_inductance"]
LINK, BAND = POLITECNICO["dc_link_voltage"], POLITECNICO["hysteresis"]
FULL_SLOPE = 2.0 / 3.0 * LINK / INDUCTANCE  # A/s, the fastest that a phase's current can go at standstill
FAULTS = {"active_turns_u": 0.8, "active_turns_w": 0.95, "eccentricity": 0.2, "magnet_strength": 0.9}


# angle and shapes


def test_sine_and_cosine_are_the_librarys():
    for angle in np.concatenate([np.linspace(-7.0, 7.0, 4001), [1e4 + 0.3, -3e5]]):
        sine, cosine = sine_and_cosine(angle / (2.0 * math.pi))
        tolerance = 1e-15 + 3e-16 * abs(angle)
        assert sine == pytest.approx(math.sin(angle), abs=tolerance)
        assert cosine == pytest.approx(math.cos(angle), abs=tolerance)


def test_a_control_cycle_of_turning_on_stays_exact():
    part = PAIRS * 837.758 * STEP  # 8000 rpm
    sine, cosine = math.sin(0.4), math.cos(0.4)
    for _ in range(125):
        sine, cosine = turned(sine, cosine, part)
    assert (sine, cosine) == pytest.approx((math.sin(0.4 + 125 * part), math.cos(0.4 + 125 * part)), abs=1e-12)


def test_the_trapezoid_is_flat_for_a_third_of_a_turn_and_straight_between():
    degrees = np.array([0.0, 15.0, 30.0, 90.0, 150.0, 165.0, 180.0, 195.0, 210.0, 330.0, 345.0, 360.0, 750.0])
    heights = [0.0, 0.5, 1.0, 1.0, 1.0, 0.5, 0.0, -0.5, -1.0, -1.0, -0.5, 0.0, 1.0]
    assert [trapezoid(angle / 360.0) for angle in degrees] == pytest.approx(heights, abs=1e-12)
    for angle in np.linspace(-1.0, 1.0, 333):
        u, v, w = three_trapezoids(angle)
        assert (v, w) == pytest.approx((trapezoid(angle - 1 / 3), trapezoid(angle + 1 / 3)), abs=1e-12)
        assert sorted(abs(shape) == 1.0 for shape in (u, v, w)) == [False, True, True]  # two phases carry, opposite
        assert u + v + w == pytest.approx(min((u, v, w), key=abs), abs=1e-12)


# winding


@pytest.mark.slow
def test_a_locked_rotor_answers_a_step_as_resistance_and_inductance_do():
    """Phase u on the upper rail, v and w on the lower: i_u = (2 Vdc / 3R)(1 - exp(-t R / L)), half back by each."""
    run = turn(winding(), 0.02, setpoint=1e6, speed=0.0, angle=0.5 * math.pi / PAIRS)
    time = STEP * np.arange(1, 20001)
    expected = 2.0 / 3.0 * LINK / RESISTANCE * -np.expm1(-time * RESISTANCE / INDUCTANCE)
    np.testing.assert_allclose(run["phase_current_u"], expected, rtol=1e-9)
    np.testing.assert_allclose(run["phase_current_v"], -0.5 * expected, rtol=1e-9)


@pytest.mark.slow
def test_a_turning_winding_is_second_order_in_the_step():
    """Legs that never switch, so that nothing but the integration counts: half the step, a quarter of the error."""

    def final(step):
        held = winding(hysteresis=math.inf, active_turns_v=0.7, eccentricity=0.1)
        return currents(turn(held, 0.02, setpoint=0.0, speed=150.0, step=step))[-1]

    exact = final(5e-7)
    coarse, fine = (np.abs(final(step) - exact).max() for step in (1.6e-5, 8e-6))
    assert coarse / fine == pytest.approx(4.0, rel=0.05)
    assert fine < 1e-4


@SHAPES
@pytest.mark.parametrize("faults", [{}, FAULTS], ids=["healthy", "faulty"])
def test_currents_add_up_to_zero(trapezoidal, faults):
    run = turn(winding(trapezoidal=trapezoidal, **faults), 0.1, setpoint=4.0, speed=60.0)
    assert np.abs(currents(run)).max() > 3.0
    assert np.abs(currents(run).sum(axis=1)).max() < 1e-14


@SHAPES
@pytest.mark.parametrize("faults", [{}, FAULTS], ids=["healthy", "faulty"])
@pytest.mark.parametrize("speed", [0.0, 80.0, -80.0])
def test_energy_balances(trapezoidal, faults, speed):
    """Out of the link = lost as heat + through the air gap + stored in the inductances, step by step and in all."""
    motor = winding(trapezoidal=trapezoidal, **faults)
    run = turn(motor, 0.1, setpoint=3.0, speed=speed, angle=0.2)
    shares = np.array([motor[f"active_turns_{phase}"][0] for phase in "uvw"])
    stored = 0.5 * (INDUCTANCE * shares**2 * currents(run) ** 2).sum(axis=1)
    mechanical = run["air_gap_torque"] * speed
    left = STEP * (run["power"] - run["loss"] - mechanical) - np.diff(stored, prepend=0.0)
    throughput = STEP * (np.abs(run["power"]) + run["loss"] + np.abs(mechanical)).sum()
    assert abs(left.sum()) < 1e-12 * throughput
    assert np.abs(left).max() < 1e-12 * STEP * np.abs(run["power"]).max()


# comparators and bridge


def test_ripple_is_the_bands_width_and_its_frequency_that_of_two_exponentials():
    """Reference a in u and -a/2 in v and w: by symmetry only u's comparator acts, between a + b and a - b.

    With u on the upper rail its current heads for 2 Vdc / 3R, with all on one rail for zero, both with L / R. A small
    step keeps what a comparator overshoots until the next one small.
    """
    setpoint, step = 3.0, 5e-8
    amplitude = KT / (1.5 * KE) * setpoint
    run = turn(winding(), 0.01, setpoint, speed=0.0, angle=0.5 * math.pi / PAIRS, step=step, settle=0.002)
    upper, lower, goal = amplitude + BAND, amplitude - BAND, 2.0 / 3.0 * LINK / RESISTANCE
    period = INDUCTANCE / RESISTANCE * (math.log(upper / lower) + math.log((goal - lower) / (goal - upper)))
    rises = np.flatnonzero(np.diff(run["leg_u"]) > 0)
    assert len(rises) > 5
    assert np.diff(rises).mean() * step == pytest.approx(period, rel=0.01)
    assert np.ptp(run["phase_current_u"]) == pytest.approx(2.0 * BAND, abs=1.1 * step * FULL_SLOPE)
    assert np.abs(np.diff(run["leg_v"])).max() == 0.0


@SHAPES
@pytest.mark.parametrize("speed", [0.0, 3.0, 60.0])
def test_currents_keep_within_twice_the_band(trapezoidal, speed):
    """A floating star point: each leg turns its own error back only while the others do not lie on the same rail.

    Errors add up to zero, so beyond twice the band one of the two others is beyond its own band on the other side; its
    leg is then on the other rail, and at least Vdc / 3 drives the error back: more than the back-EMF. What comes on top
    is one step's slope (and the jumps of the block references, which take time: flats only, a while after).
    """
    run = turn(winding(trapezoidal=trapezoidal), 0.2, setpoint=2.0, speed=speed, angle=0.3, settle=0.01)
    turn_share = PAIRS * run["angle"] / (2.0 * math.pi)
    if trapezoidal:
        shapes = np.array([three_trapezoids(share) for share in turn_share])
        carried = np.where(np.abs(shapes) == 1.0, shapes, 0.0)
        jumped = np.abs(np.diff(carried, axis=0, prepend=carried[:1])).max(axis=1) > 0.0
        since = np.arange(len(run["angle"])) - np.maximum.accumulate(np.where(jumped, np.arange(len(jumped)), -(10**6)))
        settled = since > 600
    else:
        phases = 2.0 * math.pi * (turn_share[:, None] - np.array([0.0, 1.0, 2.0]) / 3.0)
        carried = np.sin(phases)
        settled = np.full(len(carried), True)
    amplitude = KT / ((2.0 if trapezoidal else 1.5) * KE) * 2.0
    error = np.abs(currents(run) - amplitude * carried)[settled]
    slope = FULL_SLOPE + KE * speed / INDUCTANCE + PAIRS * speed * amplitude
    assert error.max() < 2.0 * BAND + slope * STEP
    assert np.mean(error < BAND + slope * STEP) > 0.9


@SHAPES
def test_a_smaller_step_changes_little(trapezoidal):
    """Switching instants fall on steps: first order. Halving the step must bring mean and ripple ever closer."""
    finest, *coarser = (
        turns(winding(trapezoidal=trapezoidal), 1, 3.0, 30.0, step=step, settle=0.01) for step in (1.25e-7, 5e-7, 1e-6)
    )
    for run, allowed in zip(coarser, (0.5, 1.0), strict=True):
        assert run["torque"].mean() == pytest.approx(finest["torque"].mean(), rel=0.004 * allowed)
        assert run["torque"].std() == pytest.approx(finest["torque"].std(), rel=0.15 * allowed)


# torque


@SHAPES
@pytest.mark.parametrize("setpoint", [2.0, -6.0])
@pytest.mark.parametrize("speed", [0.0, 1.24, 20.0])
def test_a_healthy_motors_torque_is_kt_times_the_setpoint(trapezoidal, setpoint, speed):
    motor = winding(trapezoidal=trapezoidal)
    angles = np.arange(12) * 0.137 if speed == 0.0 else [0.0]
    seconds = 0.05 if speed == 0.0 else 0.25 * 2.0 * math.pi / speed  # a period of the phases
    runs = [turn(motor, seconds, setpoint, speed, angle=angle, settle=0.01) for angle in angles]
    mean = np.mean([run["torque"].mean() for run in runs])
    assert mean == pytest.approx(KT * setpoint, rel=0.007 if trapezoidal and setpoint == 2.0 else 0.005)


def test_trapezoidal_phases_lose_torque_at_each_commutation_when_fast():
    """Near the link's limit a phase's current cannot follow its block: torque dips six times an electrical turn, 6 P.

    Sinusoidal references do not jump and keep their torque (0.2 % at that order: the ripple's band is a hexagon).
    """
    sinusoidal, blocks = (turns(winding(trapezoidal=shape), 2, 6.0, 150.0, settle=0.02) for shape in (0.0, 1.0))
    dips = [abs(order(run, "torque", 6.0 * PAIRS)) / (KT * 6.0) for run in (sinusoidal, blocks)]
    assert dips[0] < 0.004
    assert dips[1] > 0.1
    assert sinusoidal["torque"].mean() == pytest.approx(KT * 6.0, rel=0.005)
    assert blocks["torque"].mean() < 0.95 * KT * 6.0


def test_torque_saturates_hard_and_keeps_the_air_gaps():
    run = turns(winding(torque_limit=11.842), 1, 8.0, 20.0, settle=0.02)
    assert run["torque"].max() == 11.842
    assert run["torque"].mean() == pytest.approx(11.842, rel=1e-6)
    assert run["air_gap_torque"].mean() == pytest.approx(KT * 8.0, rel=0.005)
    assert turns(winding(torque_limit=11.842), 1, -8.0, 20.0, settle=0.02)["torque"].min() == -11.842


def test_a_braking_motor_feeds_the_link():
    run = turns(winding(), 1, -4.0, 100.0, settle=0.01)
    expected = KT * -4.0 * 100.0 + 1.5 * RESISTANCE * (4.0 / 3.0 * 4.0) ** 2
    assert run["power"].mean() == pytest.approx(expected, rel=0.01)


# DC link


@SHAPES
@pytest.mark.parametrize("current", [0.0, 2.0, 6.2])
def test_highest_speed_and_voltage_needed_are_each_others_inverse(trapezoidal, current):
    motor = winding(trapezoidal=trapezoidal)[0]
    assert voltage_needed(motor, highest_speed(motor, current), current) == pytest.approx(LINK, rel=1e-12)


@SHAPES
def test_a_link_too_low_to_turn_at_all(trapezoidal):
    motor = winding(trapezoidal=trapezoidal, dc_link_voltage=5.0)[0]
    assert highest_speed(motor, 6.0) == 0.0
    assert highest_speed(motor, 0.0) > 0.0


def test_above_the_highest_speed_the_current_does_not_reach_its_setpoint():
    motor = winding()
    limit = highest_speed(motor[0], 4.0)
    below, above, far = (turns(motor, 4, 4.0, share * limit, settle=0.05) for share in (0.85, 1.1, 1.3))
    assert below["torque"].mean() == pytest.approx(KT * 4.0, rel=0.01)
    assert above["torque"].mean() < 0.9 * KT * 4.0
    assert far["torque"].mean() < above["torque"].mean()
    # six-step operation: the fundamental of a phase's voltage is 2 Vdc / pi at most
    assert far["quadrature_voltage"].max() < 1.15 * 2.0 / math.pi * LINK
    assert far["power"].mean() == pytest.approx((far["loss"] + far["torque"] * 1.3 * limit).mean(), rel=0.02)


# acquisition and resolver


@SHAPES
def test_the_quadrature_current_is_the_torques(trapezoidal):
    run = turn(winding(trapezoidal=trapezoidal, current_filter=0.0), 0.05, 3.0, 50.0)
    np.testing.assert_allclose(KT * run["quadrature_current"], run["air_gap_torque"], atol=1e-12)


def test_the_direct_current_of_a_sinusoidal_drive_is_only_ripple():
    run = turns(winding(), 1, 3.0, 50.0, settle=0.02)
    assert abs(run["direct_current"].mean()) < 0.005
    assert run["quadrature_current"].mean() == pytest.approx(3.0, rel=0.005)


@pytest.mark.parametrize("speed", [10.0, 100.0])
def test_the_quadrature_voltage_is_back_emf_and_resistance(speed):
    run = turns(winding(), 1, 3.0, speed, settle=0.02)
    assert run["quadrature_voltage"].mean() == pytest.approx(KE * speed + RESISTANCE * 4.0, rel=0.01)


def test_acquisition_is_a_first_order_lag():
    """A phase current that rises straight, by r: the filtered one follows a time constant later, r tau behind."""
    lag = 5e-4
    slow, quick = (
        turn(winding(current_filter=filter_), 5e-3, setpoint=1e6, speed=0.0, angle=0.5 * math.pi / PAIRS)
        for filter_ in (lag, 0.0)
    )
    rate = np.gradient(quick["quadrature_current"], STEP)
    time = STEP * np.arange(1, len(rate) + 1)
    behind = quick["quadrature_current"] - slow["quadrature_current"]
    after = time > 8 * lag
    np.testing.assert_allclose(behind[after], lag * rate[after], rtol=0.05)  # L / R is 11 ms: nearly straight


@pytest.mark.parametrize("lead", [math.radians(2.0), math.radians(-5.0)])
def test_a_turned_resolver_costs_the_cosine_and_weakens_or_strengthens_the_field(lead):
    """The drive puts the current where it believes the quadrature axis is: P x lead off the true one.

    Torque falls to cos(P lead); sin(P lead) of the current lies along the magnets' flux, against it for a lead. The
    drive itself, which looks through the same resolver, sees nothing but its setpoint.
    """
    run = turns(winding(resolver_offset=lead), 1, 4.0, 20.0, settle=0.02)
    electrical = PAIRS * lead
    assert run["torque"].mean() == pytest.approx(KT * 4.0 * math.cos(electrical), rel=0.005)
    axes = PAIRS * run["angle"][:, None] - 2.0 * math.pi / 3.0 * np.arange(3)
    true_direct = KE / KT * (-np.cos(axes) * currents(run)).sum(axis=1)
    assert true_direct.mean() == pytest.approx(-4.0 * math.sin(electrical), rel=0.01)
    assert run["quadrature_current"].mean() == pytest.approx(4.0, rel=0.005)
    assert abs(run["direct_current"].mean()) < 0.01


def test_a_resolvers_wave_ripples_the_torque_at_twice_its_order():
    """cos(P a sin(n theta)) = J0(P a) + 2 J2(P a) cos(2 n theta) + …, Jacobi and Anger."""
    amplitude = 0.1  # rad of the shaft
    run = turns(
        winding(resolver_amplitude=amplitude, resolver_order=2.0, resolver_phase=0.0), 1, 4.0, 20.0, settle=0.02
    )
    assert run["torque"].mean() == pytest.approx(KT * 4.0 * jv(0, PAIRS * amplitude), rel=0.005)
    assert order(run, "torque", 4.0) == pytest.approx(KT * 4.0 * 2.0 * jv(2, PAIRS * amplitude), rel=0.05)


def test_a_run_in_parts_is_the_whole_run():
    motor = winding(**FAULTS)
    whole = turn(motor, 0.02, 3.0, 40.0)
    state = resting()
    turn(motor, 0.01, 3.0, 40.0, state=state)
    rest = turn(motor, 0.01, 3.0, 40.0, angle=0.4, state=state)
    for name in ("phase_current_u", "quadrature_current", "torque"):
        np.testing.assert_allclose(rest[name], whole[name][10000:], atol=1e-9)

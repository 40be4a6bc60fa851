"""Joints of which no constant is known, one recording each: what a law of friction leaves over is named as nothing."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from ema_bench_replay.recording import Recording
from ema_twin_sim.discovery.criteria.few_rows import shows_in_few_rows
from ema_twin_sim.discovery.criteria.reversals import shows_where_slowest
from ema_twin_sim.discovery.criteria.worth import has_effect_size
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.discovery.experiment.doubts import moves_one_way, reverses
from ema_twin_sim.discovery.search.found_orders import of_the_gears, resolved
from ema_twin_sim.identification.candidates import Candidate, candidates
from ema_twin_sim.identification.fit import fit
from ema_twin_sim.identification.null_hypothesis import null_hypothesis
from ema_twin_sim.identification.screening import screen
from ema_twin_sim.identification.uncertainty import covariance
from ema_twin_sim.measured.scales import to_own_units
from ema_twin_sim.plant.motion import SPEED
from tests.open_motor import open_motor
from tests.problems import problem_of

NOISE = 0.02  # A
PERIOD = 0.01  # s
DRY, VISCOUS, INERTIA, TORQUE_CONSTANT = 12.0, 25.0, 5.0, 10.0


@pytest.fixture(scope="module")
def joint():
    return open_motor(TORQUE_CONSTANT, NOISE, PERIOD, coulomb=10.0, viscous=20.0)


def moved(friction=lambda time, angle, speed: 0.0, turns=0.25, seconds=40.0, seed=1, step=0.0, sway=0.1):
    """To and fro by ``turns``, with a ``friction`` [N m] beside Coulomb's and viscous; readings in steps [A]."""
    time = np.arange(round(seconds / PERIOD)) * PERIOD
    rate = 2.0 * math.pi * 0.15
    angle = math.pi * turns * np.sin(rate * time) * (1.0 + sway * np.sin(0.31 * rate * time))
    speed = np.gradient(angle, PERIOD)
    torque = INERTIA * np.gradient(speed, PERIOD) + DRY * np.tanh(speed / 1e-3) + VISCOUS * speed
    torque = torque + friction(time, angle, speed)
    current = torque / TORQUE_CONSTANT + NOISE * np.random.default_rng(seed).standard_normal(len(time))
    if step:
        current = step * np.floor(current / step)
    signals = {"current": current, "speed": speed, "motor_position": angle}
    return Recording(f"joint_{seed}", np.arange(len(time)) * 10_000_000, signals, motor_angle_origin=0.0)


def in_own_units(recording, model):
    """What is judged, and the model's own hypothesis."""
    recordings, model = to_own_units([recording], model)
    return problem_of(list(recordings), model), null_hypothesis(model)


@pytest.mark.parametrize(("order", "offered"), [("3", False), ("5", True)])
def test_an_order_that_was_not_recorded_twice_is_not_looked_for(order, offered, joint):
    """Over half a turn, three to a turn is one bend and a half: so is a friction that is a little more at one end."""
    option = Candidate("cogging", {"order": order})
    problem, h = in_own_units(moved(turns=0.5), joint)
    assert resolved(problem, [option], h.base) == ([option] if offered else [])


@pytest.mark.parametrize(("order", "turns", "of_gears"), [(14.0, 0.5, []), (14.4, 1.0, ["14.4"])])
def test_over_half_a_turn_a_whole_order_is_none_of_a_gear(order, turns, of_gears, joint):
    """Another wave moves the strongest order by many times what noise does, to 13.95 in place of 14."""

    def cogs(time, angle, speed):
        return 1.2 * np.cos(order * angle + 0.3) + 0.9 * np.sin(8.0 * angle + 1.0)

    problem, h = in_own_units(moved(cogs, turns=turns, seconds=200.0), joint)
    assert [f"{float(found):.1f}" for found in of_the_gears(problem, fit(problem, h))] == of_gears


def test_many_cycles_within_a_quarter_of_a_turn_are_a_wave(joint):
    """Fifty to a turn are a dozen in a quarter of one; a tooth that was passed once is not seen to repeat."""
    few, many = Candidate("cogging", {"order": "16"}), Candidate("cogging", {"order": "50"})
    tooth = Candidate("tooth_fault", {"order": "1", "kind": "conservative"})
    problem, h = in_own_units(moved(turns=0.22), joint)
    assert resolved(problem, [few, many, tooth], h.base) == [many]


def test_a_wave_within_a_quarter_of_a_turn_is_found_beside_a_load(joint):
    """The load over the angle has more power, in all of the low orders, which are one wave over so little of a turn."""

    def bent(time, angle, speed):
        return 0.8 * np.cos(50.0 * angle + 0.3) + 12.0 * angle

    found = discover([moved(bent, turns=0.22, seed=k) for k in (1, 2)], joint)
    wave = found.model.effects["cogging"]
    assert wave.options["order"] == "50"
    assert wave.parameters["torque"] == pytest.approx(0.8, rel=0.1)
    assert "tooth_fault" not in found.added


def test_a_spring_is_no_friction_that_gives_way(joint):
    """Dry friction that gives way over all of the travel is a spring's torque."""

    def pulled(time, angle, speed):
        return 6.0 * angle

    assert discover([moved(pulled, seed=k) for k in (1, 2)], joint).added == ("spring_load",)
    problem, h = in_own_units(moved(pulled), joint)
    bristle = h.with_effect("presliding_friction", {}, {"stiffness": 0.1, "damping": 0.0})
    assert not has_effect_size(problem, fit(problem, h), fit(problem, bristle))


@pytest.mark.parametrize(("size", "verdict"), [(0.5, "none"), (12.0, "unknown")])
def test_what_is_too_fast_for_the_rows_is_not_nothing(size, verdict, joint):
    """Rows average a second of samples; torque that changes from each to the next is gone there, and is there."""

    def rattles(time, angle, speed):
        return size * np.random.default_rng(7).standard_normal(len(time))

    assert discover([moved(rattles, seed=k) for k in (1, 2)], joint).verdict == verdict


def test_a_load_that_took_the_place_of_two_is_judged_by_what_all_of_them_removed(joint):
    """Over so little of a turn gravity is a constant load and a spring; its own step, after theirs, removes nothing."""
    time = np.arange(4000) * 2.5e-3
    share = np.arcsin(np.sin(2.0 * math.pi * time / 3.3)) / (0.5 * math.pi)
    angle = 1.67 * share
    speed = np.gradient(angle, 2.5e-3)
    torque = 1e-4 * np.gradient(speed, 2.5e-3) + 0.023 * np.tanh(100.0 * speed)
    torque += 0.0937 - 0.02 * np.exp(-10.0 * (share + 0.3) ** 2)
    current = torque + 1e-4 * np.random.default_rng(1).standard_normal(len(time))
    signals = {"current": current, "speed": speed, "motor_position": angle}
    run = Recording("arm", np.arange(len(time)) * 2_500_000, signals, motor_angle_origin=0.0)
    machine = joint.with_value("machine.torque_constant", 1.0).with_value("machine.gear_ratio", 101.0)
    machine = machine.with_value("sensors.current_noise", 1e-4).with_value("sensors.sample_period", 2.5e-3)
    found = discover([run], machine)
    assert found.verdict == "explained"
    assert {*found.added} <= {"gravity_load", "constant_load", "spring_load"}
    assert found.unseen.removed(0, -1) > 0.99


@pytest.mark.parametrize(("backward", "told"), [(0.5, True), (0.01, False)])
@pytest.mark.parametrize("second", [1e-3, 1.0])
def test_a_motion_reverses_whatever_its_own_second_is(backward, told, second):
    """Half of it went backward, in however little of the machine's own time; a rebound at the end is no motion."""
    motion = np.zeros((1000, SPEED + 1))
    motion[:, SPEED] = np.where(np.arange(1000) < 1000 * backward, -1.0, 1.0)
    problem = SimpleNamespace(observations=[SimpleNamespace(motion=motion, period=0.01 * second)])
    assert reverses(problem) is told and moves_one_way(problem) is not told
    motion[:, SPEED] = 0.0
    assert not moves_one_way(problem)  # points that were held


def test_an_inertia_that_is_open_is_not_added_to(joint, stock):
    """Two numbers for one inertia would each be known to nothing."""

    def offered(model):
        return {c.effect for c in candidates(null_hypothesis(model))}

    assert "added_inertia" in offered(stock)
    assert "added_inertia" not in offered(joint)


def pulse(angle, height=3.0):
    away = np.abs(np.mod(angle - 1.0 + math.pi, 2.0 * math.pi) - math.pi)
    return np.where(away < 0.2, 0.5 * height * (1.0 + np.cos(math.pi * away / 0.2)), 0.0)


def test_what_lies_at_reversals_is_no_damaged_tooth(joint):
    """The machine turns at the same angles each time; a tooth is passed at every speed."""
    turns = (1.0 + 2.0 * math.pi) / math.pi  # it reverses where the tooth is

    def fitted(friction):
        problem, h = in_own_units(moved(friction, turns, sway=0.0), joint)
        option = Candidate("tooth_fault", {"order": "1", "kind": "conservative"})
        (screened,) = screen(problem, fit(problem, h), [option])
        starts = [{**screened.start, "torque": sign * screened.start["torque"]} for sign in (1.0, -1.0)]
        fits = [fit(problem, h.with_effect("tooth_fault", option.options, start), 20) for start in starts]
        return problem, min(fits, key=lambda f: f.misfits[0])  # which start does better, another processor decides

    def gives_way(time, angle, speed, travel=0.03):  # rad over which a bristle bends (Dahl)
        bent = np.zeros(len(angle))
        for k, way in enumerate(np.diff(angle), 1):
            bent[k] = np.clip(bent[k - 1] + way / travel, -1.0, 1.0)
        return DRY * (bent - np.tanh(speed / 1e-3))

    assert not shows_where_slowest(*fitted(lambda t, angle, v: pulse(angle)), "tooth_fault")
    assert shows_where_slowest(*fitted(gives_way), "tooth_fault")


def test_friction_that_comes_and_goes_does_not_warm_up(joint):
    def wanders(time, angle, speed):
        share = 0.05 * np.interp(time, [0.0, 8.0, 16.0, 24.0, 32.0, 40.0], [1.5, 0.2, 0.5, -0.9, 0.1, -0.6])
        return share * (DRY * np.tanh(speed / 1e-3) + VISCOUS * speed)

    assert discover([moved(wanders)], joint).added == ()


def test_friction_that_warms_up_is_named(joint):
    def warms(time, angle, speed):
        return -0.25 * (1.0 - np.exp(-time / 12.0)) * (DRY * np.tanh(speed / 1e-3) + VISCOUS * speed)

    assert discover([moved(warms)], joint).added == ("thermal_friction",)


@pytest.mark.parametrize(("load", "named"), [(0.0, ()), (1.2, ("constant_load",))])
def test_what_a_drive_rounds_down_is_no_load(load, named, joint):
    """Rounded down, a reading is half a step less on average, as of a constant load."""
    step = 0.05  # A, which is 0.5 N m
    assert discover([moved(lambda *_: load, step=step, seed=k) for k in (1, 2)], joint).added == named


def test_a_share_is_between_its_ends(joint):
    """Beyond what was driven a lubricant thins by a share at one speed, or by more at a higher one."""

    def thins(time, angle, speed):
        return -VISCOUS * speed * 0.9 * np.abs(speed) / (np.abs(speed) + 4.0)

    problem, h = in_own_units(moved(thins), joint)
    h = h.with_effect("shear_thinning", {}, {"fraction": 0.9, "speed": 4.0})
    f = fit(problem, h, 20)
    spread = covariance(problem, f)
    k = [free.path for free in h.free].index("effects.shear_thinning.fraction")
    assert math.sqrt(spread[k, k]) <= 1.0 / math.sqrt(12.0)
    assert np.linalg.eigvalsh(spread / np.outer(*2 * [np.sqrt(np.diag(spread))])).min() > -1e-9


@pytest.mark.parametrize(("turns", "size", "few"), [(60.0, 0.0, True), (60.0, 4.0, False), (6.0, 0.0, False)])
def test_a_wave_that_a_few_rows_show_is_none_unless_several_places_do(turns, size, few, joint):
    """Smoothing hides it but where the machine starts and reverses: any two numbers fit the rows of one such place."""
    problem, h = in_own_units(moved(lambda t, angle, v: size * np.sin(3.0 * angle), turns=turns, seconds=20.0), joint)
    wave = fit(problem, h.with_effect("cogging", {"order": "3"}, {"torque": 0.5, "phase": 0.0}))
    assert shows_in_few_rows(problem, wave, "cogging") is few


@pytest.mark.parametrize(("rest", "named"), [(15.0, {"constant_load"}), (0.0, {"gravity_load", "constant_load"})])
def test_loads_that_cancel_are_named_only_if_they_explain_the_place(rest, named, joint):
    """An arm with a counterweight has both; a bump beside them tells that the bend may be of anything."""

    def bent(time, angle, speed):
        return 20.0 * (0.12 - angle**2) + rest * np.exp(-(((angle - 0.4) / 0.08) ** 2))

    found = discover([moved(bent)], joint)
    assert {*found.added} == named
    assert found.verdict == ("unknown" if rest else "explained")

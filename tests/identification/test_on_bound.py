"""A number that stands on a bound of its search is no result: discover and fit say so, by one rule."""

import math
from dataclasses import replace

import numpy as np
import pytest

from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.fitting.fit import fit_model
from ema_twin_sim.identification.equation import EquationErrorProblem
from ema_twin_sim.identification.estimates import standard_errors
from ema_twin_sim.identification.fit import fit
from ema_twin_sim.identification.null_hypothesis import null_hypothesis
from ema_twin_sim.identification.on_bound import TURNED, on_bounds, reached_bound, torque_sign_reversed
from ema_twin_sim.measured.observe import observe
from ema_twin_sim.plant.motion import SPEED
from tests.large_arm import COULOMB, INERTIA, VISCOUS, open_arm, swings_of
from tests.problems import fit_of
from tests.recorded import changed, record


def test_the_rule():
    assert reached_bound(0.0, 0.0, 1.0, 0.1, 1.0) == "lower"
    assert reached_bound(1.0, 0.0, 1.0, 0.0, 1.0) == "upper"
    assert reached_bound(0.02, 0.0, 1.0, 0.1, 1.0) is None  # a fifth of its standard error off
    assert reached_bound(0.04, 0.0, 1.0, 10.0, 1.0) is None  # badly known, but off by a part of its size
    assert reached_bound(1e300, 0.0, math.inf, 1.0, 1.0) is None


def stribeck_seen(stock, speed, command):
    """What is said of a friction that falls over ``speed`` [rad/s], fitted to one motion."""
    effect = {"torque": 0.2, "speed": speed}
    runs = record(stock.with_effect("stribeck_friction", effect), (command,), 10.0)
    found = fit_of(runs, stock, 20, stribeck_friction={**effect, "speed": 1.0})
    return on_bounds(found.problem, found, standard_errors(found.problem, found)), found.problem


def test_a_speed_beyond_those_driven_is_on_its_bound(stock):
    told, problem = stribeck_seen(stock, 12.0, "speed-sine:0.02:0.2")
    (sentence,) = told
    bound = f"stribeck_friction: speed is on its bound {problem.fastest:.4g} rad/s"
    assert sentence.startswith(f"{bound}; record faster motion") and "\n" not in sentence


def test_a_speed_among_those_driven_is_not(stock):
    told, _ = stribeck_seen(stock, 2.0, "speed-sine:0.1:0.2")
    assert told == ()


@pytest.fixture(scope="module")
def arm():
    return open_arm()


@pytest.fixture(scope="module")
def observed(arm):
    """Its swings."""
    return [observe(swing, arm) for swing in swings_of(arm)]


@pytest.mark.parametrize(("sign", "turned"), [(1.0, False), (-1.0, True)])
def test_a_torque_that_works_against_inertia_and_friction_has_the_wrong_sign(sign, turned, arm, observed):
    problem = EquationErrorProblem([replace(o, torque=sign * o.torque) for o in observed])
    found = fit(problem, null_hypothesis(arm), 20)
    assert (TURNED in on_bounds(problem, found, standard_errors(problem, found))) == turned


@pytest.mark.parametrize(("sign", "turned"), [(1.0, False), (-1.0, True)])
def test_the_sign_is_told_beside_a_load_and_a_friction_that_is_hardly_known(sign, turned, arm, observed):
    """Held by its load, the arm shows its inertia and hardly its friction: that need not end at zero."""
    noise, noisy = np.random.default_rng(5), []
    for o in observed:
        torque = sign * (o.torque + 60.0 * noise.standard_normal(len(o.torque)))
        noisy.append(replace(o, torque=torque, torque_noise=o.torque_noise + 60.0))
    problem = EquationErrorProblem(noisy)
    h = null_hypothesis(arm).with_effect("constant_load", {}, {"torque": 1.0})
    h = h.put({free.path: 1e-3 for free in h.free if free.path in ("scale.coulomb_friction", "scale.viscous_friction")})
    assert torque_sign_reversed(problem, fit(problem, h, 20)) == turned


@pytest.mark.parametrize("turned_order", [False, True])
def test_it_does_not_matter_which_friction_the_model_names_first(turned_order):
    arm = open_arm(inertia=INERTIA)
    if turned_order:
        arm = replace(arm, effects=dict(reversed([*arm.effects.items()])))
    known = replace(arm.constants["machine.motor_inertia"], tolerance=0.05)
    arm = replace(arm, constants={**arm.constants, "machine.motor_inertia": known})
    problem = EquationErrorProblem([_with_coulomb(observe(swing, arm), -3.0 * COULOMB) for swing in swings_of(arm)])
    assert torque_sign_reversed(problem, fit(problem, null_hypothesis(arm), 20))


def _with_coulomb(o, level):
    """Rows of the arm with this Coulomb friction [N m] and no viscous one."""
    speed = o.motion[o.rows, SPEED]
    return replace(o, torque=o.torque + (level - COULOMB) * np.sign(speed) - VISCOUS * speed)


def test_a_torque_that_is_filtered_is_no_torque_of_wrong_sign(arm, observed):
    """It seems to come late, so that the inertia may end at zero; friction is as large as it is."""
    late = [replace(o, torque=o.torque - 1.5 * 40.0 * o.acceleration[: len(o.torque)]) for o in observed]
    problem = EquationErrorProblem(late)
    assert not torque_sign_reversed(problem, fit(problem, null_hypothesis(arm), 20))


@pytest.mark.parametrize("verb", ["discover", "fit"])
def test_an_open_constant_may_start_anywhere(verb):
    """A start 40,000 times too small is no obstacle: the recordings say where to begin."""
    arm = open_arm(inertia=1e-3)
    swings = swings_of(arm)
    found = discover(swings, arm) if verb == "discover" else fit_model(swings, arm, method="equation")
    assert found.model.value("machine.motor_inertia") == pytest.approx(40.0, rel=0.02)
    assert not [text for text in map(str, found.warnings) if "bound" in text]


def test_nothing_is_on_a_bound_where_all_is_well(arm):
    assert not [text for text in discover(swings_of(arm), arm).warnings if "bound" in text]
    assert np.isfinite(arm.value("machine.motor_inertia"))


@pytest.mark.slow
def test_no_load_is_named_where_the_torque_drives_neither_inertia_nor_friction():
    """A joint that somebody moves: its motor follows, and what it gives has nothing of the joint's own."""
    arm = open_arm().without_effect("gravity_load")
    rng = np.random.default_rng(1)
    moved = []
    for swing in swings_of(arm):
        position, speed = swing.signals["motor_position"], swing.signals["speed"]
        acceleration = np.gradient(speed, swing.time)
        pushed = np.interp(swing.time, np.arange(0.0, 21.0, 0.5), 150.0 * rng.standard_normal(42))
        torque = 150.0 * position - 10.0 * speed - 3.0 * np.sign(speed) - 20.0 * acceleration + pushed
        moved.append(changed(swing, current=torque / arm.value("machine.torque_constant")))
    found = discover(moved, arm)
    assert found.verdict == "unknown" and found.added == ()
    assert TURNED in found.warnings


@pytest.mark.slow
def test_gravity_is_named_where_the_motor_only_bears_it_and_a_hand_moves_the_arm():
    """Gravity compensation: the hand gives what inertia and friction take, and a little of the motor's part."""
    arm = open_arm().without_effect("gravity_load")
    moved = []
    for swing in swings_of(arm):
        position, speed = swing.signals["motor_position"], swing.signals["speed"]
        torque = 150.0 * np.sin(position) - 2.0 * np.sign(speed) - 3.0 * speed
        torque += np.random.default_rng(3).standard_normal(len(speed))
        moved.append(changed(swing, current=torque / arm.value("machine.torque_constant")))
    found = discover(moved, arm)
    assert (found.verdict, found.added) == ("explained", ("gravity_load",))
    assert TURNED not in found.warnings
    assert abs(found.parameters["gravity_load"]["torque"]["value"]) == pytest.approx(150.0, rel=0.03)

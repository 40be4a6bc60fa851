"""Beside something unknown an effect stands by its own shape, and not as the likeness of another."""

import numpy as np
import pytest

from ema_twin_sim.discovery.criteria.explained import apart
from ema_twin_sim.discovery.criteria.own_shape import by_own_shape, only_teeth, parts_the_encoders
from ema_twin_sim.discovery.search.adding import settle
from ema_twin_sim.identification.fit import fit
from ema_twin_sim.identification.generic_bases import beside_generic_bases
from tests.problems import fit_of, hypothesis_of
from tests.recorded import COMMANDS, changed, lined, record


def standing(recordings, model, effect, parameters):
    """The effects that stand where one is fitted to the recordings."""
    f = settle(fit_of(recordings, model, 20, **{effect: parameters}))
    return by_own_shape(beside_generic_bases(f.problem, f), f)


def with_friction(recordings, model, curve):
    """The recordings with more friction: ``curve`` [N m] over the size of the speed [rad/s]."""
    kt = model.value("machine.torque_constant")
    more = []
    for recording in recordings:
        speed = recording.signals["speed"]
        current = recording.signals["current"] + curve(np.abs(speed)) * np.sign(speed) / kt
        more.append(changed(recording, current=current))
    return more


def fitted_beside_lines(hidden, parameters, amplitude, stock, **fitted):
    """(fit of an effect, fit of nothing) to a machine with a hidden one, whose encoder errs within its lines [rad]."""
    runs = (*COMMANDS, "ramp:0.1")
    recordings = lined(record(stock.with_effect(hidden, parameters), runs), amplitude, 1000.0)
    start = settle(fit_of(recordings, stock))
    return settle(fit(start.problem, hypothesis_of(stock, **fitted), 20)), start


@pytest.mark.parametrize(
    ("effect", "parameters"),
    [
        ("stribeck_friction", {"torque": 0.06, "speed": 2.0}),
        ("constant_load", {"torque": 0.03}),
        ("gravity_load", {"torque": 0.04, "angle": 0.3}),
        # what is small gains little more than a basis gains by its many columns, on noise alone
        ("constant_load", {"torque": 5e-4}),
    ],
)
def test_the_true_effect_stands(effect, parameters, stock):
    recordings = record(stock.with_effect(effect, parameters), seconds=10.0)
    assert standing(recordings, stock, effect, parameters) == (effect,)


@pytest.mark.parametrize("stiffness", [0.04, 0.4])
def test_a_likeness_whose_remainder_depends_on_its_own_quantity_does_not_stand(stiffness, stock):
    """Gravity explains 99 % of a spring. What it leaves, below the sensors' noise or above, depends on position."""
    sprung = stock.with_effect("spring_load", {"stiffness": stiffness})
    recordings = record(sprung, ("ramp:0.1", "triangle:0.06:20"), 15.0)
    assert standing(recordings, stock, "gravity_load", {"torque": stiffness, "angle": 0.1}) == ()


def test_a_bump_of_friction_is_not_stribecks(stock):
    """Friction that is more around one speed in the middle, and neither at rest nor fast."""
    bumped = with_friction(record(stock), stock, lambda speed: 0.08 * np.exp(-((speed - 4.0) ** 2)))
    assert standing(bumped, stock, "stribeck_friction", {"torque": 0.05, "speed": 4.0}) == ()


def test_what_explains_as_much_beside_any_shape_stands(stock):
    """A wave of friction over the speed explains more than a bristle; but beside it the bristle explains as much."""
    bristle = {"stiffness": 4.0, "damping": 0.02}
    recordings = record(stock.with_effect("presliding_friction", bristle))
    fastest = max(np.abs(recording.signals["speed"]).max() for recording in recordings)
    waved = with_friction(recordings, stock, lambda speed: 0.05 * np.sin(2.0 * np.pi * speed / fastest))
    assert standing(waved, stock, "presliding_friction", bristle) == ("presliding_friction",)


@pytest.mark.parametrize(("amplitude", "stands"), [(0.0, ("encoder_delay",)), (4e-4, ())])
def test_a_late_encoder_stands_where_it_is_most_of_how_the_encoders_part(amplitude, stands, stock):
    """Beside lines that an encoder interpolates wrongly, a delay that takes a small part away may be their likeness."""
    late = record(stock.with_effect("encoder_delay", {"delay": 5e-4}))
    assert standing(lined(late, amplitude, 60.0), stock, "encoder_delay", {"delay": 5e-4}) == stands


@pytest.mark.parametrize(
    ("hidden", "parameters", "amplitude", "stands"),
    [
        ("shaft_compliance", {"stiffness": 18.0, "damping": 0.02}, 8e-6, True),
        ("backlash", {"width": 1e-3}, 0.0, False),
        ("backlash", {"width": 3e-3}, 0.0, False),
    ],
)
def test_a_spring_stands_beside_lines_that_err_and_not_for_play(hidden, parameters, amplitude, stands, stock):
    """The encoders part by far more than their noise in each; but most of it is the spring's where there is one."""
    spring = {"stiffness": 18.0, "damping": 0.02}
    f, start = fitted_beside_lines(hidden, parameters, amplitude, stock, shaft_compliance=spring)
    assert apart(f.problem, f, start)
    assert parts_the_encoders(f.problem, f, "shaft_compliance") == stands


def test_play_in_the_place_of_a_spring_does_not_stand(stock):
    """Its teeth wind up as the spring does, and a width besides gains a little where an encoder errs."""
    recordings = record(stock.with_effect("shaft_compliance", {"stiffness": 60.0, "damping": 0.02}))
    f = fit_of(recordings, stock, 0, backlash={"width": 5e-6})
    assert not parts_the_encoders(f.problem, f, "backlash")


@pytest.mark.parametrize(
    ("hidden", "parameters", "stands"),
    [
        ("backlash", {"width": 3e-3}, True),
        ("shaft_compliance", {"stiffness": 4.0, "damping": 0.02}, False),
    ],
)
def test_play_stands_beside_lines_that_err_and_not_for_a_soft_spring(hidden, parameters, stands, stock):
    """The lines leave far more than the encoders' noise; but nearly all that parts these is the width's, or is not."""
    f, start = fitted_beside_lines(hidden, parameters, 1e-4, stock, backlash={"width": 3e-3})
    assert apart(f.problem, f, start)
    assert parts_the_encoders(f.problem, f, "backlash") == stands
    assert only_teeth(f.problem, f, "backlash") != stands

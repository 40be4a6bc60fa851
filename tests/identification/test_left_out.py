"""What a solution moves by without some of its rows: one rule for the standard errors of both verbs."""

import numpy as np
import pytest

from ema_twin_sim.identification.uncertainty import held_out, move_without
from tests.open_motor import open_motor, recorded_motion
from tests.problems import fit_of


def test_it_is_the_solution_of_the_other_rows():
    """Of a linear problem, first order is all there is: leaving rows out and fitting anew give the same."""
    random = np.random.default_rng(3)
    slopes, measured = random.normal(size=(40, 3)), random.normal(size=40)
    inverse = np.diag([0.5, 2.0, 0.1])  # priors, at zero

    def solved(rows):
        return np.linalg.solve(slopes[rows].T @ slopes[rows] + inverse**2, slopes[rows].T @ measured[rows])

    every, kept = np.arange(40), np.arange(10, 40)
    whole = solved(every)
    residual = measured - slopes @ whole
    moved = move_without(slopes.T @ slopes + inverse**2, slopes[:10], residual[:10])
    assert whole + moved == pytest.approx(solved(kept), rel=1e-9)


def turning(name, speed, seconds=20.0, period=2e-3):
    """A motor under friction, at ``speed`` (t,) -> rad/s."""
    time = np.arange(round(seconds / period)) * period
    turns = speed(time)
    angle = np.concatenate([[0.0], np.cumsum(0.5 * (turns[1:] + turns[:-1])) * period])
    torque = 2e-4 * np.gradient(turns, period) + 4e-4 * turns + 0.02 * np.sign(turns)
    return recorded_motion(name, time, torque, turns, angle, np.random.default_rng(ord(name)))


def test_a_constant_that_the_others_hardly_tell_is_not_thrown_far_off():
    """At one speed alone, friction that grows with it and friction that does not are the same."""
    motor = open_motor(1.0, 2e-3, 2e-3, speed_noise=1e-3)
    steady = turning("s", lambda t: 8.0 * np.sign(np.sin(0.6 * t)) + 0.05 * np.sin(1.7 * t))
    swept = turning("w", lambda t: 120.0 * np.sin(0.5 * t))
    f = fit_of([steady, swept], motor)
    (_, by_steady), _ = held_out(f.problem, f)
    viscous = [free.path for free in f.hypothesis.free].index("scale.viscous_friction")
    assert by_steady[viscous] == pytest.approx(f.hypothesis.values[viscous], rel=0.2)

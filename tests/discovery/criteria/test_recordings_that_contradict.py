"""One recording that would alone have far more friction, or inertia, than the others: linear problems of few rows."""

from types import SimpleNamespace

import numpy as np
import pytest

from ema_twin_sim.criteria import PART, SMALL
from ema_twin_sim.discovery.criteria.contradictions import CONSTANTS, contradictions

ROWS = 400


def fitted(*shares, noise=1.0, size=100.0, inflation=1.0, other=0.0, file_value=1.0, prior=0.1):
    """A fit of recordings, each of which asks for so large a share more of dry friction.

    Friction takes `size` standard errors of a row, by the motion's direction; inertia something at right angles to it.
    `other` is left over beside, which no constant takes away.
    """
    random = np.random.default_rng(3)
    direction = np.sign(np.sin(np.linspace(0.0, 40.0, ROWS)))
    inertia = np.cos(np.linspace(0.0, 40.0, ROWS))
    jacobian, residual = [], []
    for share in shares:
        jacobian.append(np.stack([5.0 * inertia, np.zeros(ROWS), size * direction / file_value], 1))
        residual.append(share * size * direction + noise * random.normal(size=ROWS) + other * random.normal(size=ROWS))
    paths = [CONSTANTS["inertia"], "sensors.offset", CONSTANTS["dry friction"]]
    free = [SimpleNamespace(path=path, prior=prior) for path in paths]
    return problem_and_fit(free, [1.0, 1.0, file_value], jacobian, residual, inflation)


def problem_and_fit(free, values, jacobian, residual, inflation=1.0):
    """A problem and a fit of these free parameters, given the rows of each recording."""
    problem = SimpleNamespace(
        observations=[SimpleNamespace(name=f"run {k}") for k in range(len(residual))],
        torque_parts=[slice(k * ROWS, (k + 1) * ROWS) for k in range(len(residual))],
    )
    return problem, SimpleNamespace(
        hypothesis=SimpleNamespace(free=free, values=np.array(values)), jacobian=np.concatenate(jacobian),
        residual=np.concatenate(residual), variance_inflation=inflation,
    )  # fmt: skip


def test_none_where_all_agree():
    assert contradictions(*fitted(0.5, 0.5, 0.5)) == ()


@pytest.mark.parametrize(("share", "words"), [(0.4, "more"), (-0.4, "less")])
def test_the_one_of_another_machine_is_named_with_its_share(share, words):
    (told,) = contradictions(*fitted(0.0, share, 0.0))
    assert told.startswith(f"run 1: needs 40% {words} dry friction than the other recordings do")


def test_one_recording_alone_contradicts_nothing():
    assert contradictions(*fitted(0.4)) == ()


def test_a_share_within_what_machines_differ_by_is_none():
    assert contradictions(*fitted(0.0, 0.9 * SMALL, 0.0)) == ()
    assert len(contradictions(*fitted(0.0, 1.2 * SMALL, 0.0))) == 1


def test_a_share_that_is_hardly_known_is_none():
    """Rows that vary far more than their noise says know it a hundred times worse."""
    assert len(contradictions(*fitted(0.0, 0.4, 0.0, size=3.0))) == 1
    assert contradictions(*fitted(0.0, 0.4, 0.0, size=3.0, inflation=1e4)) == ()


def test_what_explains_little_of_a_recordings_error_is_not_said_of_it():
    """Beside a large error of another kind a constant takes on whatever fits it."""
    share, size = 0.4, 100.0
    of_all = share * size / np.sqrt(PART)  # where the friction is just that part of what is left, squared
    assert contradictions(*fitted(0.0, share, 0.0, size=size, other=1.5 * of_all)) == ()
    assert len(contradictions(*fitted(0.0, share, 0.0, size=size, other=0.5 * of_all))) >= 1


def test_shares_of_a_guess_are_shares_of_its_value():
    """An open constant is free in the file's unit: 40 % of 0.05 N m is not 0.4 N m."""
    (known,) = contradictions(*fitted(0.0, 0.4, 0.0))
    (guessed,) = contradictions(*fitted(0.0, 0.4, 0.0, file_value=0.05, prior=None))
    assert guessed == known


def accelerated(inertia, torque_rest, disturbed):
    """A fit of three recordings, of which the last has this ``inertia``, in shares of the others'.

    Its torque has a ``torque_rest`` beside what inertia and friction need; its motion is ``disturbed``, and what does
    it is in no torque: both in shares of its acceleration.
    """
    random = np.random.default_rng(3)
    wave, direction = np.sqrt(2.0) * np.cos(np.linspace(0.0, 40.0, ROWS)), np.ones(ROWS)
    jacobian, residual = [], []
    for share, rest, moved in ((1.0, 0.1, 0.0), (1.0, 0.1, 0.0), (inertia, torque_rest, disturbed)):
        acceleration = 20.0 * (wave + moved * random.normal(size=ROWS))
        jacobian.append(np.stack([acceleration, 100.0 * direction], 1))
        residual.append(20.0 * (share * wave + rest * random.normal(size=ROWS)) - acceleration)
    free = [SimpleNamespace(path=CONSTANTS[name], prior=0.1) for name in ("inertia", "dry friction")]
    return problem_and_fit(free, [1.0, 1.0], jacobian, residual)


def test_an_acceleration_that_a_disturbance_causes_shows_no_smaller_inertia():
    """A commanded ramp, whose acceleration is the ripple of its teeth, was said to need 77 % less inertia."""
    assert contradictions(*accelerated(1.0, 0.0, disturbed=1.5)) == ()


@pytest.mark.parametrize(("inertia", "words"), [(0.5, "less"), (1.5, "more")])
def test_another_inertia_that_the_torque_shows_is_named(inertia, words):
    (told,) = contradictions(*accelerated(inertia, 0.1, disturbed=0.0))
    assert told.startswith("run 2: needs ") and f"{words} inertia" in told


def test_constants_that_are_not_free_are_not_asked():
    problem, f = fitted(0.0, 0.4, 0.0)
    f.hypothesis.free[2].path = "sensors.gain"
    f.hypothesis.free[0].path = "sensors.delay"
    assert contradictions(problem, f) == ()
